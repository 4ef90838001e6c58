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
  double bend_per_m = 0;  ///< one over the radius of the cylinder that the sheet lies on, along its diagonal
};

/// A camera with a lens of the usual kind.
CameraModel TypicalCamera(CameraModel::Kind kind);

/// Views of a sheet of boards in all parts of the image; points outside the image are not seen.
std::vector<LensView> MakeViews(const ViewPlan& plan);

}  // namespace chequer::test
