#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "chequer/geometry.h"
#include "detect/homography.h"

namespace chequer {

/// A pose with how well it explains points.
struct PlanePose {
  RigidTransform camera_from_board;
  double square_error = 0;  ///< Σ of squared distances, in units of the plane z = 1
};

/// The two poses of a plane that explain a homography nearly equally well (Collins and Bartoli 2014, IPPE), each
/// refined by least squares on the point pairs; the better one first. Nothing for a degenerate or mirrored homography.
/// @param normalized_from_board homography from board points to the plane z = 1.
/// @param pairs board points (any unit, which becomes the translation's) and their images on z = 1.
std::optional<std::array<PlanePose, 2>> PlanePoses(const Eigen::Matrix3d& normalized_from_board,
                                                   std::span<const PointPair> pairs);

/// The other pose that a plane may have when seen in `pose`: its normal mirrored about the line of sight, then refined
/// so that it explains the same points best.
PlanePose MirroredPose(const RigidTransform& camera_from_board, std::span<const PointPair> pairs);

}  // namespace chequer
