#include "track/constant_velocity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "support/dense.h"
#include "support/seed.h"

namespace chequer {
namespace {

constexpr double kStep = 0.05;      // s
constexpr double kSigmaM = 2e-4;    // of a measured position
constexpr double kSigmaRad = 2e-3;  // of a measured rotation
constexpr double kUnknownSpeed = 3, kUnknownTurning = 20;

/// What a robot truly does.
struct TrueMotion {
  RigidTransform pose;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
};
using Path = std::function<TrueMotion(double time_s)>;

Matrix6d MeasurementCovariance() {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << Eigen::Vector3d::Constant(kSigmaM * kSigmaM),
      Eigen::Vector3d::Constant(kSigmaRad * kSigmaRad);
  return covariance;
}

RigidTransform Measured(const RigidTransform& truth, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
  const Eigen::Vector3d turn(normal(random), normal(random), normal(random));
  return {RotationFromVector(kSigmaRad * turn) * truth.rotation, truth.translation + kSigmaM * noise};
}

/// The filter after so many frames of a path.
ConstantVelocity Followed(const Path& path, int frames, const MotionModel& model, std::mt19937_64& random) {
  ConstantVelocity filter(Measured(path(0).pose, random), MeasurementCovariance(), kUnknownSpeed, kUnknownTurning);
  for (int frame = 1; frame < frames; ++frame) {
    filter.Predict(kStep, model);
    filter.Correct(Measured(path(frame * kStep).pose, random), MeasurementCovariance());
  }
  return filter;
}

TrueMotion Straight(double t) {
  const Eigen::Vector3d velocity(0.3, -0.2, 0.05);
  return {{RotationFromVector({0.1, 0.2, 0.7}), Eigen::Vector3d(1, 2, 0.1) + velocity * t}, velocity, {}};
}

/// A wheeled robot on a circle of 0.4 m.
TrueMotion OnCircle(double t) {
  const double rate = 1.25, radius = 0.4, heading = rate * t;
  return {{RotationFromVector({0, 0, heading}), {radius * std::sin(heading), -radius * std::cos(heading), 0.1}},
          radius * rate * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0),
          {0, 0, rate}};
}

TEST(ConstantVelocity, FindsTheVelocityOfAStraightPath) {
  std::mt19937_64 random = test::SeededGenerator();
  MotionModel model{.acceleration_m_s2 = 0.05};
  const ConstantVelocity filter = Followed(Straight, 60, model, random);
  const TrueMotion truth = Straight(59 * kStep);
  EXPECT_LT((filter.pose().translation - truth.pose.translation).norm(), 5 * kSigmaM);
  EXPECT_LT((filter.velocity() - truth.velocity).norm(), 0.01 * truth.velocity.norm());
  EXPECT_LT(filter.angular_velocity().norm(), 0.1);
}

TEST(ConstantVelocity, TurningFollowsAWheeledRobotRoundACircleWithoutALag) {
  std::mt19937_64 random = test::SeededGenerator();
  MotionModel model{.motion = Motion::kTurning, .acceleration_m_s2 = 0.05};
  const ConstantVelocity filter = Followed(OnCircle, 60, model, random);
  const TrueMotion truth = OnCircle(59 * kStep);
  EXPECT_LT((filter.velocity() - truth.velocity).norm(), 0.01 * truth.velocity.norm());
  EXPECT_NEAR(filter.angular_velocity().z(), truth.angular_velocity.z(), 0.05);
  model.motion = Motion::kStraight;
  const ConstantVelocity straight = Followed(OnCircle, 60, model, random);
  EXPECT_GT((straight.velocity() - truth.velocity).norm(), 0.03 * truth.velocity.norm()) << "the test shows nothing";
}

TEST(ConstantVelocity, TurnsThroughHalfATurn) {
  const auto spin = [](double t) {
    return TrueMotion{{RotationFromVector({0, 0, std::remainder(2.0 * t, 2 * std::numbers::pi)}), {0, 0, 0}}, {}, {}};
  };
  std::mt19937_64 random = test::SeededGenerator();
  const ConstantVelocity filter = Followed(spin, 80, {}, random);
  EXPECT_NEAR(filter.angular_velocity().z(), 2.0, 0.1);
}

/// χ² per dimension of errors against the filter's own covariance: 1 on average where that is honest. Deviations hold
/// for a robot whose acceleration is the noise that the model reckons with.
TEST(ConstantVelocity, ItsCovarianceIsHonest) {
  std::mt19937_64 random = test::SeededGenerator();
  std::normal_distribution<double> normal;
  const MotionModel model{.acceleration_m_s2 = 0.5, .angular_acceleration_rad_s2 = 1};
  double sum = 0;
  constexpr int kRuns = 60, kFrames = 30, kParts = 20;
  for (int run = 0; run < kRuns; ++run) {
    TrueMotion truth{{Eigen::Quaterniond::Identity(), {0, 0, 0}}, {0.2, 0.1, 0}, {0, 0, 0.5}};
    ConstantVelocity filter(Measured(truth.pose, random), MeasurementCovariance(), kUnknownSpeed, kUnknownTurning);
    for (int frame = 1; frame < kFrames; ++frame) {
      for (int part = 0; part < kParts; ++part) {
        const double t = kStep / kParts;
        const auto kick = [&](double acceleration) {
          return Eigen::Vector3d(std::sqrt(acceleration * acceleration * 0.1 * t) *
                                 Eigen::Vector3d(normal(random), normal(random), normal(random)));
        };
        truth.pose.translation += truth.velocity * t;
        truth.pose.rotation = (RotationFromVector(truth.angular_velocity * t) * truth.pose.rotation).normalized();
        truth.velocity += kick(model.acceleration_m_s2);
        truth.angular_velocity += kick(model.angular_acceleration_rad_s2);
      }
      filter.Predict(kStep, model);
      filter.Correct(Measured(truth.pose, random), MeasurementCovariance());
    }
    Eigen::Matrix<double, 12, 1> error;
    error << truth.pose.translation - filter.pose().translation,
        VectorFromRotation(truth.pose.rotation * filter.pose().rotation.conjugate()),
        truth.velocity - filter.velocity(), truth.angular_velocity - filter.angular_velocity();
    sum += test::SquareOver(error, filter.covariance()) / 12;
  }
  EXPECT_GT(sum / kRuns, 0.8);
  EXPECT_LT(sum / kRuns, 1.2);
}

TEST(ConstantVelocity, DistanceIsInStandardDeviations) {
  const RigidTransform origin;
  Matrix6d covariance = MeasurementCovariance();
  const ConstantVelocity filter(origin, covariance, 1, 1);
  EXPECT_NEAR(filter.Distance(origin, covariance), 0, 1e-12);
  const double both = std::numbers::sqrt2;
  EXPECT_NEAR(filter.Distance({Eigen::Quaterniond::Identity(), {3 * both * kSigmaM, 0, 0}}, covariance), 3, 1e-9);
  EXPECT_NEAR(filter.Distance({RotationFromVector({0, 4 * both * kSigmaRad, 0}), {0, 0, 0}}, covariance), 4, 1e-6);
}

TEST(ConstantVelocity, IsLessSureTheLongerNothingIsMeasured) {
  ConstantVelocity filter({}, MeasurementCovariance(), 1, 1);
  filter.Predict(0, {});
  EXPECT_NEAR(filter.covariance()(0, 0), kSigmaM * kSigmaM, 1e-12);
  double last = filter.covariance()(0, 0);
  for (int i = 0; i < 5; ++i) {
    filter.Predict(kStep, {});
    EXPECT_GT(filter.covariance()(0, 0), last);
    last = filter.covariance()(0, 0);
  }
}

}  // namespace
}  // namespace chequer
