#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "chequer/detector.h"
#include "chequer/geometry.h"

namespace chequer {

/// A marker that was measured, and where it sits on its body.
struct MountedBoard {
  BoardMeasurement board;
  RigidTransform body_from_marker;
};

/// A body's pose that explains the homographies of its markers best.
struct BodyFit {
  RigidTransform camera_from_body;
  Matrix6d covariance = Matrix6d::Zero();        ///< as RobotPose::covariance, in the camera frame
  double chi_square = 0;                         ///< distance from the homographies, by their information
  Matrix6d print_covariance = Matrix6d::Zero();  ///< the part of the covariance that prints and calibration may be off
};

/// χ² of a pose: how far it is from explaining the homographies; infinite where a marker would be behind the camera.
double ChiSquare(std::span<const MountedBoard> boards, const RigidTransform& camera_from_body);

/// The pose of a body that is free in all six directions, by least squares with the homographies' information, from a
/// start nearby. Nothing where it does not settle in front of the camera.
std::optional<BodyFit> FitFreeBody(std::span<const MountedBoard> boards, const RigidTransform& camera_from_body);

/// A body's pose upright on a plane of the world.
struct FloorFit {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< of the body's origin, world frame, metres
  double heading_rad = 0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, heading)
  double chi_square = 0;
  Eigen::Matrix3d print_covariance =
      Eigen::Matrix3d::Zero();  ///< the part of it that prints and calibration may be off
};

/// The same for a body that stands upright with its origin at a height of the world: the three numbers that are left
/// are estimated from the same homographies, so no tilt that noise makes moves them.
/// @param world_from_body a start nearby, of which position and heading are used.
std::optional<FloorFit> FitBodyOnFloor(std::span<const MountedBoard> boards, const RigidTransform& camera_from_world,
                                       double height_m, const RigidTransform& world_from_body);

}  // namespace chequer
