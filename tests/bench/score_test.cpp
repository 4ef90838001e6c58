#include "bench/score.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace chequer::bench {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

CameraModel Camera() { return {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240}; }

RigidTransform PoseAt(const Vector3d& position, const Vector3d& turn_deg = Vector3d::Zero()) {
  return {RotationFromVector(turn_deg * kDegree), position};
}

TrueMarker TruthAt(std::uint64_t id, const Vector3d& position, double cell_px = 4) {
  return {id, PoseAt(position), Camera().Project(position), cell_px};
}

Score ScoreOf(const std::vector<TrueMarker>& truth, const std::vector<Detection>& detections) {
  ScoreKeeper keeper(Camera());
  keeper.AddFrame(truth, detections);
  return keeper.Summary();
}

TEST(Score, CountsHitsWrongAndUndecided) {
  const Score score = ScoreOf({TruthAt(1, {0, 0, 1}), TruthAt(2, {0.2, 0, 1}), TruthAt(3, {0.4, 0, 1})},
                              {{1, PoseAt({0, 0, 1})},                 // right
                               {9, PoseAt({0.2, 0, 1})},               // wrong id in the right place
                               {3, PoseAt({0, 0.3, 1})},               // right id in the wrong place
                               {std::nullopt, PoseAt({0.4, 0, 1})}});  // left undecided
  EXPECT_EQ(score.markers, 3);
  EXPECT_EQ(score.hits, 1);
  EXPECT_EQ(score.wrong, 2);
  EXPECT_EQ(score.undecided, 1);
  EXPECT_DOUBLE_EQ(score.Recall(), 1.0 / 3.0);
}

TEST(Score, ADetectionHitsOnlyOnce) {
  const TrueMarker truth = TruthAt(1, {0, 0, 1});
  EXPECT_EQ(ScoreOf({truth, truth}, {{1, PoseAt({0, 0, 1})}}).hits, 1);
  const Score twice = ScoreOf({truth}, {{1, PoseAt({0.001, 0, 1})}, {1, PoseAt({0, 0, 1})}});
  EXPECT_EQ(twice.hits, 1);
  EXPECT_EQ(twice.wrong, 1);
  EXPECT_EQ(twice.pose->position_rms_mm, 0) << "the nearest counts";
}

TEST(Score, TheRadiusIsACellOrThreePixels) {
  // A millimetre across at 1 m is half a pixel.
  EXPECT_EQ(ScoreOf({TruthAt(1, {0, 0, 1}, 1)}, {{1, PoseAt({0.0058, 0, 1})}}).hits, 1);
  EXPECT_EQ(ScoreOf({TruthAt(1, {0, 0, 1}, 1)}, {{1, PoseAt({0.0062, 0, 1})}}).hits, 0);
  EXPECT_EQ(ScoreOf({TruthAt(1, {0, 0, 1}, 10)}, {{1, PoseAt({0.0198, 0, 1})}}).hits, 1);
  EXPECT_EQ(ScoreOf({TruthAt(1, {0, 0, 1}, 10)}, {{1, PoseAt({0.0202, 0, 1})}}).hits, 0);
}

TEST(Score, APoseBehindTheCameraIsWrong) {
  EXPECT_EQ(ScoreOf({TruthAt(1, {0, 0, 1})}, {{1, PoseAt({0, 0, -1})}}).wrong, 1);
}

TEST(Score, SplitsErrorsIntoDepthAndLateral) {
  const Score score = ScoreOf({TruthAt(1, {0, 0, 2}), TruthAt(2, {0, 0, 2})},
                              {{1, PoseAt({0.003, 0, 2.004}, {0, 0, 2})}, {2, PoseAt({0, 0, 2}, {0, 1, 0})}});
  ASSERT_TRUE(score.pose.has_value());
  EXPECT_NEAR(score.pose->depth_rms_mm, 4 / std::numbers::sqrt2, 1e-9);
  EXPECT_NEAR(score.pose->lateral_rms_mm, 3 / std::numbers::sqrt2, 1e-9);
  EXPECT_NEAR(score.pose->position_rms_mm, 5 / std::numbers::sqrt2, 1e-9);
  EXPECT_NEAR(score.pose->position_median_mm, 2.5, 1e-9);
  EXPECT_NEAR(score.pose->angle_rms_deg, std::sqrt(2.5), 1e-9);
  EXPECT_NEAR(score.pose->angle_median_deg, 1.5, 1e-9);
}

TEST(Score, WithoutMarkersNothingIsMissed) {
  const Score nothing = ScoreOf({}, {});
  EXPECT_EQ(nothing.Recall(), 1.0);
  EXPECT_FALSE(nothing.pose.has_value());
  EXPECT_EQ(ScoreOf({}, {{7, PoseAt({0, 0, 1})}}).wrong, 1);
}

TEST(MeanOfStream, LeavesOutFramesInWhichLittleIsKnown) {
  std::vector<double> frames(kFramesUntilKnown, 100);
  frames.insert(frames.end(), {1, 2, 6});
  EXPECT_EQ(MeanOfStream(frames), 3);
}

TEST(Median, IsTheMiddleOrTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(Median({3}), 3);
  EXPECT_EQ(Median({5, 1, 3}), 3);
  EXPECT_EQ(Median({5, 1, 3, 2}), 2.5);
}

}  // namespace
}  // namespace chequer::bench
