#include "track/constant_velocity.h"

#include <cmath>

#include "core/small_cholesky.h"

namespace chequer {
namespace {

/// How long an acceleration lasts for its standard deviation to be the one that was given.
constexpr double kAccelerationTimeS = 0.1;

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

/// Adds what white-noise acceleration of that standard deviation does in a time to a place and its rate.
void AddProcessNoise(Matrix12d& covariance, int place, int rate, double acceleration, double t) {
  const double density = acceleration * acceleration * kAccelerationTimeS;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  covariance.block<3, 3>(place, place) += density * t * t * t / 3 * unit;
  covariance.block<3, 3>(place, rate) += density * t * t / 2 * unit;
  covariance.block<3, 3>(rate, place) += density * t * t / 2 * unit;
  covariance.block<3, 3>(rate, rate) += density * t * unit;
}

}  // namespace

ConstantVelocity::ConstantVelocity(const RigidTransform& pose, const Matrix6d& covariance, double speed_m_s,
                                   double turning_rad_s)
    : pose_(pose) {
  covariance_.topLeftCorner<6, 6>() = covariance;
  covariance_.block<3, 3>(6, 6) = Eigen::Matrix3d::Identity() * speed_m_s * speed_m_s;
  covariance_.block<3, 3>(9, 9) = Eigen::Matrix3d::Identity() * turning_rad_s * turning_rad_s;
}

void ConstantVelocity::Predict(double seconds, const MotionModel& model) {
  const double t = seconds;
  const Eigen::Matrix3d turn = RotationFromVector(angular_velocity_ * t).toRotationMatrix();
  Matrix12d by_state = Matrix12d::Identity();  // the new error by the old one
  by_state.block<3, 3>(3, 3) = turn;
  by_state.block<3, 3>(3, 9) = Eigen::Matrix3d::Identity() * t;
  if (model.motion == Motion::kTurning) {
    // Along the chord: the velocity of the middle of the step.
    const Eigen::Matrix3d half = RotationFromVector(angular_velocity_ * (t / 2)).toRotationMatrix();
    by_state.block<3, 3>(0, 6) = half * t;
    by_state.block<3, 3>(0, 9) = -t * t / 2 * Cross(half * velocity_);
    by_state.block<3, 3>(6, 6) = turn;
    by_state.block<3, 3>(6, 9) = -t * Cross(turn * velocity_);
    pose_.translation += half * velocity_ * t;
    velocity_ = turn * velocity_;
  } else {
    by_state.block<3, 3>(0, 6) = Eigen::Matrix3d::Identity() * t;
    pose_.translation += velocity_ * t;
  }
  pose_.rotation = (RotationFromVector(angular_velocity_ * t) * pose_.rotation).normalized();
  covariance_ = by_state * covariance_ * by_state.transpose();
  AddProcessNoise(covariance_, 0, 6, model.acceleration_m_s2, t);
  AddProcessNoise(covariance_, 3, 9, model.angular_acceleration_rad_s2, t);
}

ConstantVelocity::Vector6d ConstantVelocity::Innovation(const RigidTransform& measured) const {
  Vector6d innovation;
  innovation << measured.translation - pose_.translation,
      VectorFromRotation(measured.rotation * pose_.rotation.conjugate());
  return innovation;
}

double ConstantVelocity::Distance(const RigidTransform& measured, const Matrix6d& covariance) const {
  const Vector6d innovation = Innovation(measured);
  const Matrix6d spread = covariance_.topLeftCorner<6, 6>() + covariance;
  return std::sqrt(innovation.dot(SmallCholesky<6>(spread).Solve(innovation)));
}

void ConstantVelocity::Correct(const RigidTransform& measured, const Matrix6d& covariance) {
  using Matrix12x6d = Eigen::Matrix<double, 12, 6>;
  const Vector6d innovation = Innovation(measured);
  const Matrix6d spread = covariance_.topLeftCorner<6, 6>() + covariance;
  const Eigen::Matrix<double, 6, 12> across = covariance_.topRows<6>();
  const Matrix12x6d gain = SmallCholesky<6>(spread).SolveEach(across).transpose();
  const Eigen::Matrix<double, 12, 1> step = gain * innovation;
  pose_.translation += step.segment<3>(0);
  pose_.rotation = (RotationFromVector(step.segment<3>(3)) * pose_.rotation).normalized();
  velocity_ += step.segment<3>(6);
  angular_velocity_ += step.segment<3>(9);
  // Joseph's form keeps it symmetric and positive whatever the numbers.
  Matrix12d rest = Matrix12d::Identity();
  rest.leftCols<6>() -= gain;
  covariance_ = (rest * covariance_ * rest.transpose() + gain * covariance * gain.transpose()).eval();
}

}  // namespace chequer
