#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "chequer/geometry.h"

namespace chequer {

/// Most markers that one robot bears.
inline constexpr int kMaxMarkersOnRobot = 2;

/// A robot's pose where it is known to stand on the floor: three numbers from the same pixels as the free pose.
struct FloorPose {
  /// Of the body's origin on the plane, world frame, metres.
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double height_m = 0;     ///< of the body's origin over the floor: the roster's. Does not travel over LCM
  double heading_rad = 0;  ///< of the body's x axis from the world's, counter-clockwise seen from above, −π..π
  /// Of (x, y, heading): m², m rad, rad².
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// The part of it that prints and calibration may be off. Does not travel over LCM.
  Eigen::Matrix3d print_covariance = Eigen::Matrix3d::Zero();

  // How much the free pose disagrees: what tells a robot that fell, was lifted, or is entered at a wrong height.
  double height_error_m = 0;  ///< of the markers' middle over where the roster says it is, positive: higher
  double tilt_rad = 0;        ///< of the body's z axis against the world's
  /// How much better the free pose explains the image; of three degrees of freedom where the robot stands on the floor.
  double chi_square = 0;
  /// It does not stand on the floor as the roster says: the numbers above are beyond their limits, and noise does not
  /// explain it. The floor pose is not to be trusted then; the free pose is.
  bool off_floor = false;
};

/// A robot of the roster as one frame shows it.
struct RobotPose {
  std::string name;
  std::array<std::uint64_t, kMaxMarkersOnRobot> ids{};  ///< of the markers it was seen by, the first marker_count
  int marker_count = 0;
  int family = 0;  ///< of the first of them

  /// frame_from_body, where the frame is the message's ("world" or "camera"): x forward, y left, z up for a body that
  /// the roster says nothing else of.
  RigidTransform frame_from_body;
  /// Of (x, y, z, θx, θy, θz): position in the frame, m², and a rotation θ about the frame's axes, rad², with
  /// R_true = Exp(θ) · R.
  Matrix6d covariance = Matrix6d::Zero();
  /// The part of it that prints and calibration may be off: it stays from frame to frame. Does not travel over LCM.
  Matrix6d print_covariance = Matrix6d::Zero();
  /// Probability that the mirrored pose is the true one, 0..0.5.
  double ambiguity = 0;

  std::optional<FloorPose> floor;  ///< in floor mode
};

/// Direction of a body's x axis in the x-y plane of the frame, from x towards y, −π..π.
inline double HeadingRad(const Eigen::Quaterniond& frame_from_body) {
  const Eigen::Vector3d x_axis = frame_from_body * Eigen::Vector3d::UnitX();
  return std::atan2(x_axis.y(), x_axis.x());
}

}  // namespace chequer
