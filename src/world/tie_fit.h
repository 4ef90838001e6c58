#pragma once

#include <span>
#include <vector>

#include "chequer/geometry.h"
#include "world/references.h"
#include "world/still_markers.h"

namespace chequer {

/// A reference and the marker that it is.
struct Tie {
  Reference said;
  StillMarker marker;
  std::size_t seen = 0;  ///< index of the marker among those that were given
};

struct TieFit {
  RigidTransform world_from_camera;
  Matrix6d covariance = Matrix6d::Zero();  ///< as WorldCalibration::covariance
  double chi_square = 0;                   ///< of the positions
};

/// world_from_camera by weighted least squares. With fewer than three places, or three on a line, orientations decide
/// what positions leave open. @pre not empty; a single tie has a heading.
TieFit FitTies(std::span<const Tie> ties, double sigma_m);

/// Where a tie's marker is seen minus where it is said to be, world frame, metres.
Eigen::Vector3d Offset(const Tie& tie, const RigidTransform& world_from_camera);

/// The longest offset that goes with how exactly the place and the pose are known: five standard deviations of the one
/// and three of the other.
double OffsetLimit(const Tie& tie, double sigma_m);

/// Whether all offsets are within their limits.
bool AllAgree(std::span<const Tie> ties, const RigidTransform& world_from_camera, double sigma_m);

/// What the distances as seen are, as a multiple of those that the list says, where one factor explains them; 1 where
/// there are fewer than two ties.
double ScaleOf(std::span<const Tie> ties);

}  // namespace chequer
