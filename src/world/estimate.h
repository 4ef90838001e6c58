#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "chequer/geometry.h"
#include "world/references.h"
#include "world/still_markers.h"

namespace chequer {

/// How one reference agrees with the rest.
struct ReferenceResidual {
  std::size_t seen = 0;                                ///< index into the markers that were given
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< where it is seen minus where it is said to be, world frame
  double limit_m = 0;                 ///< of the offset's length, beyond which it contradicts the others
  std::optional<double> tilt_rad;     ///< of its face against the vertical, where it is said to lie flat
  std::optional<double> heading_rad;  ///< seen minus said, where a heading was said
};

/// Where the camera stands.
struct WorldEstimate {
  RigidTransform world_from_camera;
  /// As WorldCalibration::covariance.
  Matrix6d covariance = Matrix6d::Zero();
  double rms_m = 0;  ///< of the residuals' lengths
  std::vector<ReferenceResidual> residuals;
  std::vector<std::uint64_t> unseen;  ///< references that no frame shows
};

/// From markers at known places: least squares over positions, each weighted by the exactness of its measuring and of
/// its pose; where a heading is said, or all places lie on a line, orientations count too.
/// Throws std::runtime_error where too few are seen to tell, or where they contradict each other, naming the references
/// that do not fit the others, or what else is wrong (all distances off by a factor, a left-handed list, a reference
/// that moved).
WorldEstimate EstimateFromReferences(const ReferenceList& list, std::span<const StillMarker> seen);

/// From one marker: the world frame is the marker's (x right, y up on the board, z out of it, the origin its centre).
WorldEstimate EstimateFromMarker(const StillMarker& origin);

/// From three markers that lie on the floor as an L: the first is the origin, the second lies on the x axis, the third
/// on the side of positive y. Residuals tell how far the third is beside the y axis. Throws std::runtime_error where
/// they lie nearly on a line, the L is left-handed, or its angle is more than 3 degrees from a right one.
WorldEstimate EstimateFromL(std::span<const StillMarker, 3> seen);

}  // namespace chequer
