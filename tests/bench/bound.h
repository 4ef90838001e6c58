#pragma once

#include <span>
#include <vector>

#include "chequer/geometry.h"
#include "evaluate/track.h"
#include "simulate/pose_bound.h"

namespace chequer::bench {

/// Errors that poses with the least covariances show on average.
struct ErrorBound {
  double position_rms_mm = 0;
  double angle_rms_deg = 0;
  /// Along a straight track, whose line and orientation take up a part of the errors; the means are not given.
  TrackErrors track;
};

/// @pre at least three true poses on a straight line, and as many covariances.
ErrorBound BoundOfTrack(std::span<const RigidTransform> truth, std::span<const Matrix6d> covariances);

/// Of poses each by itself, and where levels and blur are known.
struct ErrorBounds {
  ErrorBound alone, levels_known;
};
ErrorBounds BoundsOfTrack(std::span<const RigidTransform> truth, std::span<const PoseBounds> bounds);

}  // namespace chequer::bench
