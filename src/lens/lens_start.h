#pragma once

#include <optional>
#include <span>
#include <vector>

#include "lens/bundle.h"

namespace chequer {

/// Where calibration begins.
struct LensStart {
  Bundle bundle;
  std::vector<bool> placed;  ///< by board: whether it was seen together with others, so that its place is known
};

/// Finds a first guess without knowing anything: tries focal lengths from very wide to very long, lays the boards out
/// on the sheet by the homographies of the views, and keeps what explains a few of the views best. Nothing where no
/// guess explains them. @pre points.on_board_m in metres, at least one view with 6 points.
std::optional<LensStart> StartBundle(std::span<const LensView> views, int width, int height, CameraModel::Kind kind);

/// The pose in which a camera sees the sheet, from the homography of a view's points. Nothing where they do not
/// determine one.
std::optional<RigidTransform> PoseOfSheet(const LensView& view, const CameraModel& camera,
                                          std::span<const BoardPlace> boards);

}  // namespace chequer
