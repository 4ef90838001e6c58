#pragma once

#include <array>
#include <optional>

#include "chequer/geometry.h"
#include "detect/common/board_geometry.h"

namespace chequer {

/// A board's homography as measured.
struct MeasuredHomography {
  BoardGeometry geometry;  ///< its plane is that of a calibrated lens
  /// Inverse of the covariance of its parameters.
  BoardGeometry::Information information = BoardGeometry::Information::Zero();
};

/// Derivative of a homography's parameters by (x, y, z, θx, θy, θz) as in MarkerPose::covariance.
using HomographyByPose = Eigen::Matrix<double, BoardGeometry::kParameters, 6>;

/// The parameters of the homography that a board's pose makes, and their derivative. @pre the board's centre lies in
/// front of the camera. @param cell_m width and height of a cell. @param focal of the plane, pixels.
BoardGeometry::Parameters HomographyOfPose(const RigidTransform& camera_from_board, const Eigen::Vector2d& cell_m,
                                           double focal, HomographyByPose* by_pose);

/// The two poses in which a board looks nearly the same, of what the homography is near the board's centre alone (Collins
/// and Bartoli 2014, IPPE). Nothing for a degenerate or mirrored homography. @param cell_m, @param focal as above.
std::optional<std::array<RigidTransform, 2>> PosesAtCentre(const BoardGeometry& geometry, const Eigen::Vector2d& cell_m,
                                                           double focal);

/// A pose with how well it explains a homography.
struct PlanePose {
  RigidTransform camera_from_board;  ///< metres
  /// Of (x, y, z, θx, θy, θz) as in MarkerPose::covariance; of the better one alone.
  Matrix6d covariance = Matrix6d::Zero();
  double chi_square = 0;  ///< distance from the homography, by its information
};

/// Those two poses, each moved to where it explains the measured homography best: six parameters instead of eight, by
/// least squares with its information, which holds all that the image says. The better one first. Nothing for a
/// degenerate or mirrored homography. 2.6 µs. @param cell_m width and height of a cell. @param focal of the plane,
/// pixels.
std::optional<std::array<PlanePose, 2>> PlanePoses(const MeasuredHomography& measured, const Eigen::Vector2d& cell_m,
                                                   double focal);

}  // namespace chequer
