// What the frames of a stream teach of the levels of cells.
#include "detect/fit/learnt_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "chequer/detector.h"
#include "core/median.h"
#include "simulate/inks.h"
#include "simulate/random.h"
#include "support/dense.h"
#include "support/pose_errors.h"
#include "support/same_bits.h"
#include "support/scenes.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

using namespace std::chrono_literals;

constexpr auto kBetweenFrames = 16667us;

/// Passes frames through a detector with a memory.
class LevelFollower {
 public:
  LevelFollower(const DetectorOptions& options, bool learns) : detector_(Learning(options, learns)) {}

  test::Detected Next(const ImageView& image, std::chrono::nanoseconds after = kBetweenFrames) {
    now_ += after;
    test::Detected found;
    detector_.Detect(image, now_, memory_, found.markers);
    found.stats = detector_.stats();
    return found;
  }
  const DetectorMemory& memory() const { return memory_; }

 private:
  static DetectorOptions Learning(DetectorOptions options, bool learns) {
    options.learn_levels = learns;
    return options;
  }

  Detector detector_;
  DetectorMemory memory_;
  std::chrono::nanoseconds now_{1s};
};

/// Errors of poses, and what they claim.
struct Accuracy {
  test::PoseErrors errors;
  double square = 0;
  std::vector<float> deviations;
  int learnt = 0;

  void Add(const std::vector<MarkerPose>& found, const FrameTruth& truth) {
    for (const MarkerPose& marker : found)
      for (const TrueMarker& known : truth.markers) {
        if (marker.id != known.id) continue;
        errors.Add(known.camera_from_marker, marker);
        square += (known.camera_from_marker.translation - marker.camera_from_marker.translation).squaredNorm();
        deviations.push_back(static_cast<float>(std::sqrt(marker.covariance.topLeftCorner<3, 3>().trace())));
        learnt += marker.Has(Warning::kLevelsLearnt);
      }
  }
  double rms() const { return std::sqrt(square / errors.poses()); }
  double median() { return double{MedianInPlace(deviations)}; }
};

/// What is found of it is the same, up to its pose.
void ExpectSameBoard(const MarkerPose& learnt, const MarkerPose& alone) {
  EXPECT_FALSE(alone.Has(Warning::kLevelsLearnt));
  EXPECT_EQ(learnt.id, alone.id);
  EXPECT_EQ(learnt.corners_used, alone.corners_used);
  if (learnt.Has(Warning::kLevelsLearnt)) {
    // It is that of another pose, which may lie a little farther off.
    const auto of_position = [](const MarkerPose& marker) { return marker.covariance.topLeftCorner<3, 3>().trace(); };
    EXPECT_LT(of_position(learnt), 1.01 * of_position(alone));
    // One of two poses that the corners leave open has another tilt, which is known as well as that one shows it.
    const bool ambiguous = learnt.ambiguity > 0 || alone.ambiguity > 0;
    EXPECT_TRUE(ambiguous || learnt.covariance.trace() < 1.01 * alone.covariance.trace());
    return;
  }
  EXPECT_EQ(learnt.warnings, alone.warnings);
  EXPECT_EQ(learnt.covariance, alone.covariance);
  EXPECT_EQ(learnt.camera_from_marker.translation, alone.camera_from_marker.translation);
}

/// With the option, and without it.
struct Both {
  Accuracy learnt, alone;
};
Both Follow(const test::StreamFrames& stream, std::string_view of_phase) {
  Both both;
  LevelFollower with(stream.Options(), true), without(stream.Options(), false);
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const test::Detected found = with.Next(frame.image.view());
    test::Detected same = without.Next(frame.image.view());
    EXPECT_EQ(found.stats.boards, same.stats.boards);
    EXPECT_EQ(found.markers.size(), same.markers.size());
    for (std::size_t k = 0; k < std::min(found.markers.size(), same.markers.size()); ++k)
      ExpectSameBoard(found.markers[k], same.markers[k]);
    if (stream.phase(i) != of_phase) continue;
    both.learnt.Add(found.markers, frame.truth);
    both.alone.Add(same.markers, frame.truth);
  }
  return both;
}

/// A phase after a calm one. Cells of `cell_px`.
std::string Driving(double cell_px, const std::string& phase) {
  return R"(
seed = 5
[camera]
size = "640x480"
focal_px = 800
distance = )" +
         std::to_string(800 * 0.1 / 6 / cell_px) + R"(
fps = 60
exposure_ms = 1
[swarm]
robots = 6
side = 0.1
speed = 0.2
[[phase]]
kind = "calm"
frames = 16
[[phase]]
name = "then"
)" + phase;
}

void ExpectHonest(const Both& both) {
  EXPECT_GT(both.learnt.errors.position(), 0.7);
  EXPECT_LT(both.learnt.errors.position(), 1.5);
  EXPECT_GT(both.learnt.errors.orientation(), 0.7);
  EXPECT_LT(both.learnt.errors.orientation(), 1.5);
}

TEST(LearntLevels, MakePosesOfACalmStreamBetter) {
  Both both = Follow(test::StreamFrames(Driving(5.6, "kind = \"calm\"\nframes = 40\n")), "then");
  EXPECT_GT(both.learnt.learnt, 9 * both.learnt.errors.poses() / 10);
  EXPECT_LT(both.learnt.median(), 0.96 * both.alone.median()) << "claimed";
  EXPECT_LT(both.learnt.rms(), 0.96 * both.alone.rms()) << "true";
  ExpectHonest(both);
}

TEST(LearntLevels, KeepPosesHonestWhereLightChanges) {
  for (const char* phase :
       {"kind = \"dark\"\nframes = 20\n", "kind = \"flicker\"\nfrequency_hz = 100\nframes = 20\n"}) {
    SCOPED_TRACE(phase);
    Both both = Follow(test::StreamFrames(Driving(6.7, phase)), "then");
    EXPECT_LE(both.learnt.median(), both.alone.median());
    EXPECT_LT(both.learnt.rms(), 1.01 * both.alone.rms());
    ExpectHonest(both);
  }
}

TEST(LearntLevels, KeepPosesHonestWhereBoardsMove) {
  Both both = Follow(test::StreamFrames(Driving(6.7, "kind = \"fast\"\nspeed = 1.5\nframes = 20\n")), "then");
  EXPECT_LE(both.learnt.median(), both.alone.median());
  ExpectHonest(both);
}

bool IsLearnt(const test::Detected& found) {
  EXPECT_EQ(found.markers.size(), 1u);
  return !found.markers.empty() && found.markers[0].Has(Warning::kLevelsLearnt);
}

/// Frame `i` of a board that stands still.
Image StillFrame(test::KnownFrame& frame, int i) {
  frame.seed = 100 + static_cast<std::uint64_t>(i);
  return frame.Draw();
}

DetectorOptions LearningOptions(const test::KnownFrame& frame) {
  DetectorOptions options;
  options.families = {{.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = 0.12, .roster = {}}};
  options.camera = frame.options.camera;
  return options;
}

/// A follower that has learnt a board.
struct Learnt {
  test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 3, 7, 3);
  LevelFollower follower{LearningOptions(frame), true};
  int frames = 0;

  Learnt() {
    EXPECT_FALSE(NextIsLearnt()) << "nothing is known yet";
    for (int i = 0; i < 5; ++i) EXPECT_TRUE(NextIsLearnt()) << i;
  }
  bool NextIsLearnt(std::chrono::nanoseconds after = kBetweenFrames) {
    return IsLearnt(follower.Next(StillFrame(frame, frames++).view(), after));
  }
};

TEST(LearntLevels, StayWhereTheLightChanges) {
  Learnt learnt;
  learnt.frame.options.sensor.exposure *= 0.5;
  EXPECT_TRUE(learnt.NextIsLearnt());
  learnt.frame.options.lighting.gradient = 0.2;
  EXPECT_TRUE(learnt.NextIsLearnt()) << "it falls off over the board";
  const Eigen::Array3f warm(1, 0.8f, 0.5f);
  InkSet& inks = learnt.frame.scene.markers[0].inks;
  for (Eigen::Vector3f* ink : {&inks.black, &inks.white, &inks.blue, &inks.yellow}) ink->array() *= warm;
  EXPECT_TRUE(learnt.NextIsLearnt()) << "of another colour";
}

TEST(LearntLevels, AreForgottenWhereABoardContradictsThem) {
  {
    Learnt learnt;
    learnt.frame.options.lighting.haze = 0.2;
    EXPECT_FALSE(learnt.NextIsLearnt()) << "haze lifts dark cells";
    EXPECT_TRUE(learnt.NextIsLearnt());
  }
  Learnt learnt;
  learnt.frame.scene.markers[0].inks = *NamedInks("faded");
  EXPECT_FALSE(learnt.NextIsLearnt()) << "another print with the same id";
  EXPECT_TRUE(learnt.NextIsLearnt());
}

TEST(LearntLevels, AreForgottenWithTheBoard) {
  {
    Learnt learnt;
    EXPECT_FALSE(learnt.NextIsLearnt(1s)) << "after a gap";
    EXPECT_TRUE(learnt.NextIsLearnt());
  }
  Learnt learnt;
  std::vector<SceneMarker> away;
  std::swap(learnt.frame.scene.markers, away);
  EXPECT_TRUE(learnt.follower.Next(StillFrame(learnt.frame, 50).view()).markers.empty());
  std::swap(learnt.frame.scene.markers, away);
  EXPECT_FALSE(learnt.NextIsLearnt()) << "it was lost";
  EXPECT_TRUE(learnt.NextIsLearnt());
}

TEST(LearntLevels, NeedAMemoryAndKeepItSmall) {
  test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 3, 7, 3);
  DetectorOptions options = LearningOptions(frame);
  options.learn_levels = true;
  Detector alone(options), off(LearningOptions(frame));
  LevelFollower follower(options, true), again(options, true);
  std::size_t bytes = 0;
  for (int i = 0; i < 6; ++i) {
    const Image image = StillFrame(frame, i);
    const test::Detected found = follower.Next(image.view()), same = again.Next(image.view());
    EXPECT_EQ(test::DifferenceOf(found, same), "");
    test::Detected by_alone, by_off;
    alone.Detect(image.view(), by_alone.markers);
    off.Detect(image.view(), by_off.markers);
    by_alone.stats = alone.stats(), by_off.stats = off.stats();
    EXPECT_EQ(test::DifferenceOf(by_alone, by_off), "");
    EXPECT_LT(follower.memory().bytes(), 8000u);
    if (i == 0) bytes = follower.memory().bytes();
    EXPECT_EQ(follower.memory().bytes(), bytes);
  }
}

/// Normal equations of the shared unknowns and twelve levels; a difference of levels, and ways in which light may
/// change them.
struct Problem {
  static constexpr int kShared = LevelProducts::kShared, kLevels = 12, kAll = kShared + kLevels;
  Eigen::MatrixXd normal;
  Eigen::Matrix<double, kLevels, 1> difference;
  Eigen::Matrix<double, kLevels, LevelProducts::kLights> lights;

  Problem() {
    Random random(7);
    Eigen::MatrixXd rows(kAll, 2 * kAll);
    for (double& value : rows.reshaped()) value = random.Uniform(-1, 1);
    normal = test::Product(rows, rows.transpose());
    for (double& value : lights.reshaped()) value = random.Uniform(0.5, 1);
    for (double& value : difference) value = random.Uniform(-0.2, 0.2);
  }
  OwnEstimate Own(double pixel_variance) const {
    return {test::Inverse(normal).topLeftCorner<kShared, kShared>(), pixel_variance, kLevels};
  }
  LevelProducts Products() const {
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(kAll, kShared + 1 + LevelProducts::kLights);
    columns.topLeftCorner<kShared, kShared>().setIdentity();
    columns.col(kShared).tail<kLevels>() = difference;
    columns.bottomRightCorner<kLevels, LevelProducts::kLights>() = lights;
    LevelProducts products(1);
    products.products = test::Sandwich(columns.transpose(), normal);
    return products;
  }
  /// What the pixels tell of the levels, without what light may change.
  Eigen::MatrixXd KnownOfLevels() const {
    const Eigen::MatrixXd known = normal.bottomRightCorner<kLevels, kLevels>() -
                                  test::Sandwich(normal.bottomLeftCorner<kLevels, kShared>(),
                                                 test::Inverse(normal.topLeftCorner<kShared, kShared>()));
    return known -
           test::Sandwich(test::Product(known, lights), test::Inverse(test::Sandwich(lights.transpose(), known)));
  }
};

TEST(LearntLevels, AreAGaussianPrior) {
  constexpr int kShared = Problem::kShared, kLevels = Problem::kLevels, kAll = Problem::kAll;
  const Problem problem;
  const LevelProducts products = problem.Products();
  const double pixel_variance = 2, frames = 5;
  WalkingValue light{.variance = pixel_variance / products.LightInformation() / frames};
  light.Age(1, 0);
  LearntStep step;
  ASSERT_TRUE(UseLearnt(products, problem.Own(pixel_variance), light, step));
  const Eigen::MatrixXd prior = frames * problem.KnownOfLevels();
  Eigen::MatrixXd with_prior = problem.normal;
  with_prior.bottomRightCorner<kLevels, kLevels>() += prior;
  Eigen::VectorXd pull = Eigen::VectorXd::Zero(kAll);
  pull.tail<kLevels>() = -test::Product(prior, problem.difference);
  const Eigen::MatrixXd covariance = test::Inverse(with_prior);
  const LevelProducts::SharedSquare of_shared = covariance.topLeftCorner<kShared, kShared>();
  EXPECT_LT((step.covariance - of_shared).norm(), 1e-9 * of_shared.norm());
  const Eigen::Matrix<double, kShared, 1> moves = test::Product(covariance, pull).topRows<kShared>();
  EXPECT_LT((step.moves - moves).norm(), 1e-9 * moves.norm());
  EXPECT_NEAR(light.variance * products.LightInformation(), pixel_variance / (frames + 1), 1e-9);
}

TEST(LearntLevels, WalkAsFarAsTheyAreSeenToWalk) {
  // Own estimates of a value that walks, told with variance 1: steps of variance 0.5, or none.
  for (const double step : {0.5, 0.0}) {
    Random random(3);
    WalkingValue value{.variance = 1, .step = 1};
    double truth = 0, known = double{random.Normal()}, sum = 0;
    constexpr int kFrames = 400, kSettled = 100;
    for (int i = 0; i < kFrames; ++i) {
      truth += std::sqrt(step) * double{random.Normal()};
      value.Age(1, 0);
      const double off = truth + double{random.Normal()} - known, expected = 1 + value.variance;
      value.LearnStep(off * off - expected, 16 * expected);
      known += value.variance / expected * off;
      value.variance /= expected;
      // Where there are no steps, noise seems to be some, as far as they are not told apart: it may be better known.
      if (i >= kSettled) sum += (truth - known) * (truth - known) / value.variance / (kFrames - kSettled);
    }
    EXPECT_GT(sum, step > 0 ? 0.7 : 0.4) << step;
    EXPECT_LT(sum, 1.5) << step;
  }
}

}  // namespace
}  // namespace chequer
