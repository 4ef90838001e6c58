#pragma once

#include <cstdint>
#include <vector>

#include "chequer/camera_model.h"
#include "lens/lens_views.h"

namespace chequer::test {

/// How a target is shown to a camera.
struct ViewPlan {
  CameraModel camera;
  int count = 18;
  int board_columns = 3, board_rows = 2;  ///< boards on the sheet
  double board_side_m = 0.06;             ///< each of 5 x 5 points
  double max_tilt_rad = 0.6;
  double noise_px = 0.05;
  std::uint64_t seed = 1;
};

/// A camera with a lens of the usual kind.
CameraModel TypicalCamera(CameraModel::Kind kind);

/// Views of a sheet of boards in all parts of the image; points outside the image are not seen.
std::vector<LensView> MakeViews(const ViewPlan& plan);

}  // namespace chequer::test
