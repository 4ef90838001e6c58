#include "simulate/stream_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace chequer {
namespace {

std::vector<FramePlan> PlanOf(const std::string& text) { return PlanStream(ParseScenario(text, "s.toml")); }

std::string PhaseText(const std::string& kind, int frames, const std::string& more = {}) {
  return "[[phase]]\nkind = \"" + kind + "\"\nframes = " + std::to_string(frames) + "\n" + more + "\n";
}

/// The mean over an exposure in small steps: what a shutter does.
double MeanLight(double hz, double depth, double middle_s, double length_s) {
  constexpr int kSteps = 20000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    sum += 1 + depth * std::cos(2 * M_PI * hz * (middle_s + ((i + 0.5) / kSteps - 0.5) * length_s));
  return sum / kSteps;
}

TEST(StreamPlan, AveragesFlickerOverTheExposure) {
  for (const double length_s : {0.0005, 0.004, 0.01, 0.013})
    for (const double middle_s : {0.0, 0.0031, 0.0167})
      EXPECT_NEAR(FlickerOf(100, 0.4, middle_s, length_s).At(0), MeanLight(100, 0.4, middle_s, length_s), 1e-7);
  EXPECT_NEAR(FlickerOf(100, 0.4, 0.001, 0.01).At(0), 1, 1e-12) << "a whole period sees no flicker";
  // A later row sees what an exposure sees whose middle is later.
  EXPECT_NEAR(FlickerOf(100, 0.4, 0.001, 0.004).At(0.003), MeanLight(100, 0.4, 0.004, 0.004), 1e-7);
}

TEST(StreamPlan, ABeatOfTheLampsAgainstTheShutter) {
  const auto frames = PlanOf("[camera]\nfps = 60\nexposure_ms = 1\n" + PhaseText("flicker", 60, "depth = 0.5"));
  // 100 Hz seen 60 times a second repeats after 3 frames.
  EXPECT_NEAR(frames[1].flicker.At(0), frames[4].flicker.At(0), 1e-9);
  EXPECT_GT(std::abs(frames[1].flicker.At(0) - frames[0].flicker.At(0)), 0.1);
}

TEST(StreamPlan, LosesFramesInAGapAndNoneWhileTheCameraIsClosed) {
  const auto frames = PlanOf("[camera]\nfps = 50\n" + PhaseText("calm", 2) + PhaseText("gap", 5) +
                             PhaseText("calm", 2) + PhaseText("reopen", 10) + PhaseText("calm", 2));
  ASSERT_EQ(frames.size(), 6u);
  const auto sequence = [&](std::size_t i) { return frames[i].sequence; };
  EXPECT_EQ(sequence(1), 1u);
  EXPECT_EQ(sequence(2), 7u);
  EXPECT_EQ(sequence(4), 9u);
  EXPECT_NEAR(frames[2].time_s - frames[1].time_s, 6 / 50.0, 1e-12);
  EXPECT_NEAR(frames[4].time_s - frames[3].time_s, 11 / 50.0, 1e-12);
}

TEST(StreamPlan, KnocksAllDirectionsUpToTheLimit) {
  const auto frames =
      PlanOf("[camera]\nsize = \"640x480\"\nfocal_px = 1000\n" + PhaseText("knock", 400, "max_px = 10"));
  double longest = 0, shortest = 100;
  Eigen::Vector3d sum(0, 0, 0);
  for (const FramePlan& frame : frames) {
    // In the middle of the picture a small turn moves by so much.
    const double length_px = 1000 * frame.swing_rad.norm();
    longest = std::max(longest, length_px);
    shortest = std::min(shortest, length_px);
    sum += frame.swing_rad.normalized();
    EXPECT_LE(length_px, 10 + 1e-9);
    EXPECT_NEAR(frame.CameraAt(0.5).angularDistance(frame.camera_from_level), 0, 1e-9);
    EXPECT_NEAR(frame.CameraAt(0).angularDistance(frame.CameraAt(1)), frame.swing_rad.norm(), 1e-9);
  }
  EXPECT_GT(longest, 8);
  EXPECT_LT(shortest, 1);
  EXPECT_LT(sum.norm() / 400, 0.1);
}

TEST(StreamPlan, KeepsTheCameraTurned) {
  const auto frames =
      PlanOf("[camera]\nfps = 50\n" + PhaseText("turn", 20, "turn_deg = 10\nover_s = 0.2") + PhaseText("calm", 2));
  const auto angle = [&](std::size_t i) {
    return frames[i].camera_from_level.angularDistance(Eigen::Quaterniond::Identity()) * 180 / M_PI;
  };
  EXPECT_NEAR(angle(0), 0, 0.01);
  EXPECT_NEAR(angle(5), 5, 0.1);
  EXPECT_NEAR(angle(15), 10, 1e-6);
  EXPECT_NEAR(angle(21), 10, 1e-6);
  EXPECT_GT(frames[5].swing_rad.norm(), 0) << "a turn makes motion blur";
  EXPECT_NEAR(frames[15].swing_rad.norm(), 0, 1e-12);
}

TEST(StreamPlan, FollowsTheLightWithALag) {
  const std::string camera =
      "[camera]\nfps = 50\nexposure_ms = 2\n[camera.auto_exposure]\nlag_s = 0.1\nlongest_ms = 8\nlargest_gain = 3\n";
  const auto frames = PlanOf(camera + PhaseText("calm", 2) + PhaseText("dark", 100, "light = 0.1") +
                             PhaseText("reopen", 10) + PhaseText("calm", 2));
  const auto level = [&](std::size_t i) { return frames[i].light * frames[i].exposure_s / 0.002 * frames[i].gain; };
  EXPECT_NEAR(level(1), 1, 1e-9);
  EXPECT_NEAR(level(2), 0.1, 1e-9) << "the first dark frame comes as a surprise";
  EXPECT_LT(level(4), 0.3);
  // After one time constant of 5 frames, in logarithms: 0.1 to the power of exp(−1).
  EXPECT_NEAR(level(7), std::pow(0.1, std::exp(-1.0)), 1e-6);
  EXPECT_NEAR(level(101), 1, 0.01);
  EXPECT_NEAR(frames[101].exposure_s, 0.008, 1e-9) << "exposure first";
  EXPECT_NEAR(frames[101].gain, 2.5, 0.01) << "then gain";
  EXPECT_NEAR(frames[102].exposure_s, 0.002, 1e-9) << "opened anew";
}

TEST(StreamPlan, OccludesWhatThePhaseSays) {
  const auto frames = PlanOf("[swarm]\nrobots = 12\n[camera]\nfps = 10\n" +
                             PhaseText("hands", 40, "share = 0.25\noccluded = [0.2, 0.3]\nhand_s = 1.0"));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    int hands = 0;
    for (const auto& hand : frames[i].hands) {
      if (!hand) continue;
      ++hands;
      const Eigen::Vector2d from = hand->from.cwiseMax(0), to = hand->to.cwiseMin(1);
      EXPECT_GE((to - from).prod(), 0.2 - 1e-9);
      EXPECT_LE((to - from).prod(), 0.3 + 1e-9);
    }
    EXPECT_EQ(hands, 3);
  }
  const auto of = [&](std::size_t i) {
    std::string who;
    for (const auto& hand : frames[i].hands) who += hand ? 'x' : '-';
    return who;
  };
  EXPECT_EQ(of(0), of(9));
  EXPECT_NE(of(9) + of(19), of(10) + of(20));
}

}  // namespace
}  // namespace chequer
