#include "simulate/layouts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "simulate/truth.h"

namespace chequer {
namespace {

constexpr TrackCase kTracks[] = {TrackCase::kCloseDist, TrackCase::kMedDist, TrackCase::kFarDist, TrackCase::kInc30d};

CameraModel Overhead() {
  CameraModel camera{.width = 1920, .height = 1080, .fx = 1400, .fy = 1400, .cx = 955, .cy = 546};
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.12, 0.03, 0.0005, -0.0003, 0};
  return camera;
}

SwarmOptions FiftyRobots() {
  SwarmOptions options;
  options.camera = Overhead();
  const MarkerCode code(MarkerSize{}, Variant::kSecded);
  for (std::uint64_t id = 0; id < 50; ++id) options.boards.push_back(MakeBoard(code, id));
  return options;
}

TEST(PublicationTrack, IsAStraightLineInTheMarkersPlane) {
  const MarkerCode code(MarkerSize{}, Variant::kSecded);
  for (const TrackCase track : kTracks)
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const auto frames = PublicationTrack(track, code, seed);
      ASSERT_EQ(frames.size(), 8u);
      EXPECT_EQ(TruthOf(frames, PublicationCamera()).size(), 8u)
          << TrackName(track) << " seed " << seed << " leaves the frame";
      const Eigen::Vector3d first = frames[0].camera_from_marker.translation;
      const Eigen::Vector3d step = frames[1].camera_from_marker.translation - first;
      const Eigen::Vector3d normal = frames[0].camera_from_marker.rotation * Eigen::Vector3d::UnitZ();
      EXPECT_NEAR(normal.dot(step), 0, 1e-12);
      EXPECT_NEAR(-normal.z(), track == TrackCase::kInc30d ? std::cos(M_PI / 6) : 1, 1e-12);
      for (std::size_t i = 0; i < frames.size(); ++i)
        EXPECT_LT((frames[i].camera_from_marker.translation - first - static_cast<double>(i) * step).norm(), 1e-9);
    }
}

TEST(Swarm, RobotsNeverOverlapNorLeaveTheFrame) {
  const SwarmOptions options = FiftyRobots();
  const Swarm swarm(options, 3);
  for (double t = 0; t < 10; t += 0.73) {
    const auto markers = swarm.At(std::chrono::duration<double>(t));
    const auto truth = TruthOf(markers, options.camera);
    ASSERT_EQ(truth.size(), 50u) << "at " << t << " s";
    for (std::size_t i = 0; i < truth.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        // Cell pitch × 6 × √2 is the diagonal of a board, up to the pitch's foreshortening.
        EXPECT_GT((truth[i].center_px - truth[j].center_px).norm(), 0.95 * 6 * std::sqrt(2.0) * truth[i].cell_px)
            << i << " and " << j << " at " << t << " s";
  }
}

TEST(Swarm, RobotsMoveSteadily) {
  const SwarmOptions options = FiftyRobots();
  const Swarm swarm(options, 4);
  const double dt = 1 / 60.0;
  std::vector<SceneMarker> before = swarm.At(std::chrono::duration<double>(0));
  int moving = 0;
  for (int frame = 1; frame < 60; ++frame) {
    const auto now = swarm.At(std::chrono::duration<double>(frame * dt));
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double moved = (now[i].camera_from_marker.translation - before[i].camera_from_marker.translation).norm();
      EXPECT_LE(moved, options.max_speed_m_s * dt * 1.0001);
      moving += moved > 0.1 * options.max_speed_m_s * dt;
    }
    before = now;
  }
  EXPECT_GT(moving, 59 * 50 * 9 / 10);
}

TEST(Swarm, SameSeedSameSwarm) {
  const auto at = [](std::uint64_t seed) {
    return Swarm(FiftyRobots(), seed).At(std::chrono::seconds(1))[7].camera_from_marker.translation;
  };
  EXPECT_EQ(at(5), at(5));
  EXPECT_NE(at(5), at(6));
}

TEST(Swarm, BoardsMayDifferInSide) {
  SwarmOptions options = FiftyRobots();
  for (std::size_t i = 0; i < options.boards.size(); ++i) options.sides_m.push_back(i % 2 == 0 ? 0.1 : 0.05);
  const auto markers = Swarm(options, 2).At(std::chrono::seconds(0));
  EXPECT_EQ(markers[4].side_m, 0.1);
  EXPECT_EQ(markers[5].side_m, 0.05);
  options.sides_m.pop_back();
  EXPECT_THAT(options.Check(), ::testing::HasSubstr("sides_m"));
}

TEST(Swarm, SaysHowManyFitWhereNotAllDo) {
  SwarmOptions options = FiftyRobots();
  options.side_m = 0.8;
  try {
    Swarm(options, 1);
    FAIL() << "50 boards of 0.8 m fit nowhere";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("50 markers do not fit"));
  }
}

TEST(SwarmOptions, CheckNamesWhatIsWrong) {
  SwarmOptions options = FiftyRobots();
  EXPECT_EQ(options.Check(), "");
  options.distance_m = 0;
  EXPECT_THAT(options.Check(), ::testing::HasSubstr("distance_m"));
}

}  // namespace
}  // namespace chequer
