#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "chequer/camera_file.h"
#include "chequer/camera_model.h"
#include "lens/lens_views.h"
#include "lens/print_stretch.h"

namespace chequer {

struct LensCalibrationOptions {
  int width = 0;  ///< of the images, pixels
  int height = 0;
  CameraModel::Kind kind = CameraModel::Kind::kBrownConrady;
};

/// What became of a view.
struct CalibratedView {
  std::string name;
  double rms_px = 0;
  bool used = false;
  std::string why_not;  ///< empty where it was used
};

/// A point with how far it is seen from where the calibration has it.
struct LensResidual {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d error_px = Eigen::Vector2d::Zero();
};

struct LensCalibration {
  CameraModel camera;
  CalibrationRecord record;             ///< the date is left to the caller
  std::vector<CalibratedView> views;    ///< in the order given
  std::vector<LensResidual> residuals;  ///< of the views that were used
  PrintStretch print;                   ///< of the target; the camera allows for it where it matters
  SheetBend bend;                       ///< of the target; the camera allows for it
  int boards = 0;                       ///< of the target
  int loose_boards = 0;                 ///< of them, those that no view ties to the others; they were left out
};

/// Calibrates a lens from views of a flat target. Nothing need be known before but the boards themselves; how they lie
/// on their sheet is found out. Views and boards in views that disagree with the others are left out and named.
/// Throws std::runtime_error saying what is missing where the views do not determine the lens: too few, none tilted, or
/// a target that is not one flat sheet.
LensCalibration CalibrateLens(const std::vector<LensView>& views, const LensCalibrationOptions& options);

}  // namespace chequer
