#include "detect/pose/print_effect.h"

#include <Eigen/Cholesky>

namespace chequer {
namespace {

using Parameters = BoardGeometry::Parameters;

}  // namespace

PrintColumns HomographyByPrint(const BoardGeometry& geometry, double scale,
                               const Eigen::Matrix<double, BoardGeometry::kParameters, 2>& by_register) {
  PrintColumns by_print = PrintColumns::Zero();
  const Parameters h = geometry.parameters();
  // A wider board has more of the plane in a cell: the homography's first column grows.
  for (int axis = 0; axis < 2; ++axis)
    for (int row = 0; row * 3 + axis < BoardGeometry::kParameters; ++row)
      by_print(row * 3 + axis, axis) = scale * h[row * 3 + axis];
  by_print.rightCols<2>() = by_register;
  return by_print;
}

BoardGeometry::Information Widened(const BoardGeometry::Information& information, const PrintColumns& by_print) {
  const PrintColumns weighted = information * by_print;
  const Eigen::Matrix4d inner = Eigen::Matrix4d::Identity() + by_print.transpose() * weighted;
  return information - weighted * inner.llt().solve(weighted.transpose());
}

Matrix6d PrintCovariance(const PlanePose& pose, const BoardMeasurement& measured) {
  HomographyByPose by_pose;
  HomographyOfPose(pose.camera_from_board, {measured.cell_m, measured.cell_height_m}, measured.focal_px, &by_pose);
  // The pose of least squares follows the homography by (Jᵀ I J)⁻¹ Jᵀ I, and (Jᵀ I J)⁻¹ is its covariance.
  const Eigen::Matrix<double, 6, 4> by_print =
      pose.covariance * by_pose.transpose() * (measured.information * measured.by_print);
  return by_print * by_print.transpose();
}

}  // namespace chequer
