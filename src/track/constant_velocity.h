#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>

#include "chequer/geometry.h"
#include "core/track_state.h"

namespace chequer {

/// What a robot does while nothing is measured.
enum class Motion : std::uint8_t {
  kStraight,  ///< it keeps its velocity in the room: right for robots that move in any direction
  kTurning,   ///< it keeps its velocity against its own body, which turns at the yaw rate: right for wheeled robots
};

struct MotionModel {
  Motion motion = Motion::kStraight;
  /// Standard deviation of the acceleration that the filter reckons with, lasting a tenth of a second, m/s².
  double acceleration_m_s2 = 0.5;
  /// The same of the angular acceleration, rad/s².
  double angular_acceleration_rad_s2 = std::numbers::pi;
};

/// A Kalman filter of one body's pose with constant velocity and constant angular velocity (Bar-Shalom, Li and
/// Kirubarajan 2001, section 6.2: white-noise acceleration), in three dimensions. The rotation is kept as a quaternion
/// and its error as a rotation vector about the frame's axes (a multiplicative filter, Markley 2003).
class ConstantVelocity {
 public:
  using Vector6d = Eigen::Matrix<double, 6, 1>;

  /// Stands where it was first seen, with a velocity that is not known: of standard deviation `speed_m_s` and
  /// `turning_rad_s`.
  ConstantVelocity(const RigidTransform& pose, const Matrix6d& covariance, double speed_m_s, double turning_rad_s);

  /// Moves it on by a time. @pre seconds ≥ 0.
  void Predict(double seconds, const MotionModel& model);

  /// How far a measured pose is from the predicted one, in units of its expected spread (Mahalanobis), 0..: its square
  /// is χ² of six degrees of freedom where the model holds.
  double Distance(const RigidTransform& measured, const Matrix6d& covariance) const;

  /// Takes a measured pose. @param covariance of (position, rotation about the frame's axes), positive definite.
  void Correct(const RigidTransform& measured, const Matrix6d& covariance);

  const RigidTransform& pose() const { return pose_; }
  const Eigen::Vector3d& velocity() const { return velocity_; }
  const Eigen::Vector3d& angular_velocity() const { return angular_velocity_; }
  /// Order of TrackState::covariance.
  const Matrix12d& covariance() const { return covariance_; }

 private:
  /// Measured minus predicted: metres, and the rotation between them about the frame's axes.
  Vector6d Innovation(const RigidTransform& measured) const;

  RigidTransform pose_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_ = Eigen::Vector3d::Zero();
  Matrix12d covariance_ = Matrix12d::Zero();
};

}  // namespace chequer
