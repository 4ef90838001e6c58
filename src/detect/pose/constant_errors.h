#pragma once

#include "chequer/detector.h"
#include "detect/common/board_geometry.h"
#include "detect/pose/plane_pose.h"

namespace chequer {

// What is not known of a print, or of the camera's calibration, moves a board's homography alike in all frames. To
// first order, h moves by the columns B of its derivatives by what is not known, each times its standard deviation, and
// its covariance is Σ + B Bᵀ (forward propagation; Hartley and Zisserman 2004, result 5.6). Least squares with the
// inverse of that sees no more in the image than is certain.

/// Derivative of a homography's parameters by a print's width and height, each times its standard deviation `scale`,
/// and, as they were fitted, by the place of its blue ink against its black one, right and down.
PrintColumns HomographyByPrint(const BoardGeometry& geometry, double scale,
                               const Eigen::Matrix<double, BoardGeometry::kParameters, 2>& by_register);

/// How a homography's parameters move with what the lens's calibration may be off, at fixed pixels: by least squares
/// over a board of that size.
CameraColumns HomographyByCamera(const BoardGeometry& geometry, MarkerSize size, const Lens& lens);

/// What of a calibration is not known where its file does not say (kUsualFocalError): both focal lengths err together.
LensCovariance UsualLensCovariance(const CameraModel& camera);

/// Inverse of a covariance that was the inverse of `information` and is larger by B Bᵀ now (Woodbury).
template <int kColumns>
BoardGeometry::Information Widened(const BoardGeometry::Information& information,
                                   const Eigen::Matrix<double, BoardGeometry::kParameters, kColumns>& by) {
  using Square = Eigen::Matrix<double, kColumns, kColumns>;
  const Eigen::Matrix<double, BoardGeometry::kParameters, kColumns> weighted = information * by;
  const Square inner = Square::Identity() + by.transpose() * weighted;
  return information - weighted * inner.llt().solve(weighted.transpose());
}

/// The part of a pose's covariance that its print and its camera's calibration may be off: that of the pose which the
/// columns of by_print and by_camera lead to.
Matrix6d ConstantCovariance(const PlanePose& pose, const BoardMeasurement& measured);

}  // namespace chequer
