#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/geometry.h"
#include "lens/lens_views.h"

namespace chequer {

/// How a board lies on the sheet: sheet_from_board, a turn in the plane and a shift.
struct BoardPlace {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double heading_rad = 0;

  Eigen::Vector2d operator*(const Eigen::Vector2d& on_board_m) const {
    return position_m + Eigen::Rotation2Dd(heading_rad) * on_board_m;
  }
};

/// How the sheet bends: z = ½ pᵀ C p over its flat frame, and what lies farther out comes nearer by as much as keeps
/// lengths on a cylinder. Entries xx, xy and yy of C, 1/m; positive: the middle lies behind the rim.
struct SheetBend {
  Eigen::Vector3d curvature = Eigen::Vector3d::Zero();

  /// How z rises with x and y.
  Eigen::Vector2d Slope(const Eigen::Vector2d& flat_m) const {
    return {curvature[0] * flat_m.x() + curvature[1] * flat_m.y(),
            curvature[1] * flat_m.x() + curvature[2] * flat_m.y()};
  }
  Eigen::Vector3d operator*(const Eigen::Vector2d& flat_m) const {
    const Eigen::Vector2d slope = Slope(flat_m);
    const double twice_z = slope.dot(flat_m);
    const Eigen::Vector2d nearer = flat_m - twice_z / 6 * slope;
    return {nearer.x(), nearer.y(), twice_z / 2};
  }
  /// The curvature along the direction in which it is largest, either way.
  double LargestPerM() const {
    const double mean = (curvature[0] + curvature[2]) / 2, half = (curvature[0] - curvature[2]) / 2;
    return std::abs(mean) + std::hypot(half, curvature[1]);
  }
};

/// All unknowns of a calibration.
struct Bundle {
  CameraModel camera;
  SheetBend bend;
  std::vector<BoardPlace> boards;                 ///< the first stays where it is: it is the sheet's frame
  std::vector<RigidTransform> camera_from_sheet;  ///< one a view
};

struct BundleOptions {
  int max_passes = 60;
  /// Residuals beyond count linearly (Huber), pixels; 0: all count by their square.
  double robust_px = 0;
  /// Whether the sheet's bend is an unknown, too; else it stays as it is.
  bool bends = false;
};

struct BundleFit {
  double rms_px = 0;  ///< root mean square of the distances over all points
  bool converged = false;
  /// Covariance of the lens parameters (fx fy cx cy, coefficients) with the sheet's bend, the boards' places and the
  /// views' poses free.
  /// From how the views disagree, each taken as one observation: it holds also where the points of a view err together.
  Eigen::MatrixXd lens_covariance;
};

/// Moves all unknowns to the least squares of the distances between points as seen and as the bundle has them
/// and of the sheet's bend over what is usual of paper that is glued to something (Levenberg-Marquardt; poses
/// eliminated by the Schur complement, as Triggs et al. 2000 describe).
/// @pre as many poses as views, boards for every index in the views.
BundleFit FitBundle(std::span<const LensView> views, const BundleOptions& options, Bundle& bundle);

/// Where a point should be seen; nothing behind the camera.
std::optional<Eigen::Vector2d> PredictPixel(const Bundle& bundle, std::size_t view, const SeenPoint& point);

}  // namespace chequer
