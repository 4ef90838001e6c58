#include "evaluate/track.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace chequer {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

RigidTransform PoseAt(const Vector3d& position, const Vector3d& turn_deg = Vector3d::Zero()) {
  return {RotationFromVector(turn_deg * kDegree), position};
}

TEST(Errors, AreMeasuredInBothForms) {
  // 3² + 4² = 25.
  const ErrorMeasures measures = MeasureErrors(std::vector<double>{3, 0, 4, 0});
  EXPECT_DOUBLE_EQ(measures.rmse, 2.5);
  EXPECT_DOUBLE_EQ(measures.mae, 1.75);
  EXPECT_DOUBLE_EQ(measures.printed_rmse, 1.25);
  EXPECT_DOUBLE_EQ(measures.printed_mae, 1.75);
  EXPECT_DOUBLE_EQ(measures.largest, 4);
}

TEST(Errors, OfNothingAreZero) { EXPECT_EQ(MeasureErrors({}).rmse, 0); }

TEST(Track, DistancesAreFromTheBestLine) {
  // Four corners of a long rectangle: the line runs along its middle.
  const std::vector<RigidTransform> poses{PoseAt({0, 0.002, 1}), PoseAt({0, -0.002, 1}), PoseAt({1, 0.002, 1}),
                                          PoseAt({1, -0.002, 1})};
  const TrackErrors errors = MeasureTrack(poses);
  EXPECT_NEAR(errors.linear_rms_mm, 2, 1e-9);
  EXPECT_NEAR(errors.linear_mean_mm, 2, 1e-9);
  EXPECT_NEAR(errors.angular_rms_deg, 0, 1e-6);
}

TEST(Track, RmsAndMeanDifferWhereErrorsDo) {
  // Off the line y = 0 by 0, 3, 3, −3, −3, 0 mm, balanced about the middle: neither offset nor slope is left.
  const std::vector<RigidTransform> poses{PoseAt({-3, 0, 1}),     PoseAt({-2, 0.003, 1}), PoseAt({-1, -0.003, 1}),
                                          PoseAt({1, -0.003, 1}), PoseAt({2, 0.003, 1}),  PoseAt({3, 0, 1})};
  const TrackErrors errors = MeasureTrack(poses);
  EXPECT_NEAR(errors.linear_rms_mm, 3 * std::sqrt(4.0 / 6), 1e-9);
  EXPECT_NEAR(errors.linear_mean_mm, 2, 1e-9);
}

TEST(Track, RunsAlongItsOwnDirection) {
  const Vector3d direction = Vector3d(1, 2, -2) / 3;
  std::vector<RigidTransform> poses;
  for (const double s : {0.0, 0.3, 0.9}) poses.push_back(PoseAt(Vector3d(0.1, 0, 1) + s * direction));
  const TrackFit fit = FitTrack(poses);
  EXPECT_LT((fit.direction - direction).norm(), 1e-9);
  EXPECT_NEAR(fit.along_m[0], -0.4, 1e-9);
  EXPECT_NEAR(fit.along_m[2], 0.5, 1e-9);
  for (const double distance : fit.distance_m) EXPECT_NEAR(distance, 0, 1e-9);
}

TEST(Track, AnglesAreFromTheMeanOrientation) {
  const std::vector<RigidTransform> poses{PoseAt({0, 0, 1}, {0, 0, 3}), PoseAt({1, 0, 1}, {0, 0, -3}),
                                          PoseAt({2, 0, 1}, {0, 0, 0})};
  const TrackErrors errors = MeasureTrack(poses);
  EXPECT_NEAR(errors.angular_rms_deg, std::sqrt(6.0), 1e-6);
  EXPECT_NEAR(errors.angular_mean_deg, 2, 1e-6);
  EXPECT_NEAR(errors.linear_rms_mm, 0, 1e-9);
}

TEST(Track, TheSignOfQuaternionsDoesNotMatter) {
  std::vector<RigidTransform> poses{PoseAt({0, 0, 1}, {0, 170, 3}), PoseAt({1, 0, 1}, {0, 170, 3}),
                                    PoseAt({2, 0, 1}, {0, 170, 3})};
  poses[1].rotation.coeffs() *= -1;
  EXPECT_NEAR(MeasureTrack(poses).angular_rms_deg, 0, 1e-5);
}

TEST(AngleBetween, IgnoresTheSignOfQuaternions) {
  const Eigen::Quaterniond a = RotationFromVector({0, 0, 30 * kDegree});
  const Eigen::Quaterniond minus_a(-a.w(), -a.x(), -a.y(), -a.z());
  EXPECT_NEAR(AngleBetweenDeg(a, minus_a), 0, 1e-6);
  EXPECT_NEAR(AngleBetweenDeg(a, Eigen::Quaterniond::Identity()), 30, 1e-9);
}

RigidTransform Pose(const Eigen::Vector3d& position, double heading_rad = 0) {
  return {RotationFromVector({0, 0, heading_rad}), position};
}

TrackShape Shape(const std::vector<RigidTransform>& poses) { return ShapeOf(poses, FitTrack(poses)); }

TEST(TrackShape, ATrackWithNoiseIsStraight) {
  for (const double noise_m : {0.0, 0.001, 0.02}) {
    std::vector<RigidTransform> poses;
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 1);
    for (int i = 0; i < 60; ++i)
      poses.push_back(Pose({0.01 * i + noise_m * noise(random), noise_m * noise(random), 1 + noise_m * noise(random)},
                           0.3 * noise(random)));
    EXPECT_TRUE(Shape(poses).is_straight) << noise_m;
    EXPECT_FALSE(Shape(poses).is_turning);
  }
}

TEST(TrackShape, ALensThatBendsALineIsNoOtherPath) {
  std::vector<RigidTransform> poses;
  for (int i = 0; i < 60; ++i) poses.push_back(Pose({0.02 * i, 0.01 * std::sin(M_PI * i / 59), 1}));
  EXPECT_TRUE(Shape(poses).is_straight) << "10 mm of bow over 1.2 m are what is to be measured";
}

TEST(TrackShape, ACircleAndACornerAreNotStraight) {
  std::vector<RigidTransform> circle, corner;
  for (int i = 0; i < 60; ++i) circle.push_back(Pose({std::cos(0.1 * i), std::sin(0.1 * i), 0}, 0.1 * i));
  EXPECT_FALSE(Shape(circle).is_straight);
  EXPECT_TRUE(Shape(circle).is_turning);
  for (int i = 0; i < 60; ++i) corner.push_back(Pose({0.01 * std::min(i, 30), 0.01 * std::max(0, i - 30), 0}));
  EXPECT_FALSE(Shape(corner).is_straight);
}

}  // namespace
}  // namespace chequer
