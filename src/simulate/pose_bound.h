#pragma once

#include "chequer/geometry.h"
#include "simulate/render.h"

namespace chequer {

/// The least covariance that an unbiased estimate of a marker's pose can have in a frame of that camera: the inverse of
/// the Fisher information (Cramér and Rao) of all samples within the board, numerically from rendered light, with the
/// sensor's own noise and rounding. Not known to the estimate are the pose, the blur and the light of every cell in
/// every channel; edges between the board and what is around it tell nothing. For a Bayer sensor the bound is that of
/// its samples, so it holds for the colour image made of them, too. As MarkerPose::covariance.
/// @pre the marker is a checkerboard that IsDrawable; no lighting options, no JPEG.
Matrix6d PoseBound(const SceneMarker& marker, const RenderOptions& options);

/// The same, and that of an estimate which knows the blur and the light of every cell: what many frames of the same
/// boards can tell of one pose at best.
struct PoseBounds {
  Matrix6d alone = Matrix6d::Zero(), levels_known = Matrix6d::Zero();
};
PoseBounds PoseBoundsOf(const SceneMarker& marker, const RenderOptions& options);

}  // namespace chequer
