#pragma once

#include <Eigen/Core>
#include <optional>

#include "chequer/camera_model.h"

namespace chequer {

/// Numbers of a lens that calibration determines: fx fy cx cy and the distortion coefficients.
inline constexpr int kMostLensParameters = 9;
/// 4, 8 or 9 by the model.
int LensParameterCount(CameraModel::Kind kind);

/// The same numbers in the order of a camera file. @param index 0 … LensParameterCount − 1.
double& LensParameter(CameraModel& camera, int index);

/// Where a point of the camera frame is seen, with its derivatives. Nothing where it lies behind the camera.
struct SeenWithDerivatives {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_point = Eigen::Matrix<double, 2, 3>::Zero();
  /// Columns beyond the count are zero.
  Eigen::Matrix<double, 2, kMostLensParameters> by_lens = Eigen::Matrix<double, 2, kMostLensParameters>::Zero();
};
std::optional<SeenWithDerivatives> ProjectWithDerivatives(const CameraModel& camera,
                                                          const Eigen::Vector3d& x_in_camera);

}  // namespace chequer
