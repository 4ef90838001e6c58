#include "detect/pose/homography_moves.h"
#include "detect/pose/plane_pose.h"

namespace chequer {

PrintColumns HomographyByPrint(const BoardGeometry& geometry, double scale,
                               const Eigen::Matrix<double, BoardGeometry::kParameters, 2>& by_register) {
  PrintColumns by_print = PrintColumns::Zero();
  const BoardGeometry::Parameters h = geometry.parameters();
  // A wider board has more of the plane in a cell: the homography's first column grows.
  for (int axis = 0; axis < 2; ++axis)
    for (int row = 0; row * 3 + axis < BoardGeometry::kParameters; ++row)
      by_print(row * 3 + axis, axis) = scale * h[row * 3 + axis];
  by_print.rightCols<2>() = by_register;
  return by_print;
}

LensCovariance UsualLensCovariance(const CameraModel& camera) {
  LensCovariance covariance = LensCovariance::Zero();
  const Eigen::Vector2d focal = kUsualFocalError * Eigen::Vector2d(camera.fx, camera.fy);
  covariance.topLeftCorner<2, 2>() = focal * focal.transpose();
  return covariance;
}

CameraColumns HomographyByCamera(const BoardGeometry& geometry, MarkerSize size, const Lens& lens) {
  return HomographyByMoves<9, 3>(
      geometry, size, [&](const Eigen::Vector2d& board) { return lens.PlaneByCalibration(geometry.ToPlane(board)); });
}

Matrix6d ConstantCovariance(const PlanePose& pose, const BoardMeasurement& measured) {
  HomographyByPose by_pose;
  HomographyOfPose(pose.camera_from_board, {measured.cell_m, measured.cell_height_m}, measured.focal_px, &by_pose);
  // The pose of least squares follows the homography by (Jᵀ I J)⁻¹ Jᵀ I, and (Jᵀ I J)⁻¹ is its covariance.
  const Eigen::Matrix<double, 6, BoardGeometry::kParameters> solved = pose.covariance * by_pose.transpose();
  const Eigen::Matrix<double, 6, 4> by_print = solved * (measured.information * measured.by_print);
  const Eigen::Matrix<double, 6, 9> by_camera = solved * (measured.information * measured.by_camera);
  return by_print * by_print.transpose() + by_camera * by_camera.transpose();
}

}  // namespace chequer
