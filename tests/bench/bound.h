#pragma once

#include <span>
#include <vector>

#include "chequer/geometry.h"
#include "evaluate/track.h"
#include "simulate/render.h"

namespace chequer::bench {

/// The least covariance that an unbiased estimate of a marker's pose can have in a frame of that camera: the inverse of
/// the Fisher information (Cramér and Rao) of all samples within the board, numerically from rendered light, with the
/// sensor's own noise and rounding. Not known to the estimate are the pose, the blur and the light of every cell in
/// every channel; edges between the board and what is around it tell nothing. For a Bayer sensor the bound is that of
/// its samples, so it holds for the colour image made of them, too. As MarkerPose::covariance.
/// @pre the marker is a checkerboard that IsDrawable; no lighting options, no JPEG.
Matrix6d PoseBound(const SceneMarker& marker, const RenderOptions& options);

/// Errors that poses with the least covariances show on average.
struct ErrorBound {
  double position_rms_mm = 0;
  double angle_rms_deg = 0;
  /// Along a straight track, whose line and orientation take up a part of the errors; the means are not given.
  TrackErrors track;
};

/// @pre at least three true poses on a straight line, and as many covariances.
ErrorBound BoundOfTrack(std::span<const RigidTransform> truth, std::span<const Matrix6d> covariances);

}  // namespace chequer::bench
