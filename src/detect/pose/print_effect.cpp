#include "detect/pose/print_effect.h"

#include <Eigen/Cholesky>

namespace chequer {
namespace {

using Parameters = BoardGeometry::Parameters;

/// How the homography moves when corner c lies pulled(c) · along(axis) away from where the pattern has it, cells: the
/// least squares of the corners' pixels.
class PulledCorners {
 public:
  PulledCorners(const BoardGeometry& geometry, MarkerSize size, std::span<const std::uint8_t> saturated)
      : geometry_(geometry) {
    BoardGeometry::Information normal = BoardGeometry::Information::Zero();
    for (int corner = 0; corner < CornerCount(size); ++corner) {
      const Eigen::Vector2d at = CornerOnBoard(size, corner / (size.cols - 1), corner % (size.cols - 1));
      const Eigen::Matrix2d pixel_by_board = geometry.PlaneByBoard(at);
      BoardGeometry::Derivative by_moves;
      for (int axis = 0; axis < 2; ++axis) by_moves.row(axis) = BoardGeometry::MoveByParameters(at, axis);
      const BoardGeometry::Derivative in_pixels = pixel_by_board * by_moves;
      normal += in_pixels.transpose() * in_pixels;
      // Of a corner's edges in either direction, each of its two dark cells has one.
      double blue = 0;
      for (const int cell : CellsAround(size, corner))
        if (IsDark(cell / size.cols, cell % size.cols) && saturated[static_cast<std::size_t>(cell)] != 0) blue += 0.5;
      gradient_ += blue * in_pixels.transpose() * pixel_by_board;
    }
    normal_.compute(normal);
  }

  Parameters Along(int axis) const {
    // Where the print's corner lies farther along, a point of the plane is taken for one less far along.
    const Parameters moves = -normal_.solve(gradient_.col(axis));
    constexpr double kStep = 1e-4;  // of the moves: to first order
    BoardGeometry moved = geometry_;
    moved.MoveCoordinates(kStep * moves);
    return (moved.parameters() - geometry_.parameters()) / kStep;
  }

 private:
  const BoardGeometry& geometry_;
  Eigen::LLT<BoardGeometry::Information> normal_{BoardGeometry::Information::Identity()};
  Eigen::Matrix<double, BoardGeometry::kParameters, 2> gradient_ =
      Eigen::Matrix<double, BoardGeometry::kParameters, 2>::Zero();
};

}  // namespace

PrintColumns HomographyByPrint(const BoardGeometry& geometry, MarkerSize size, std::span<const std::uint8_t> saturated,
                               const PrintTolerance& tolerance, const Eigen::Vector2d& cell_m) {
  PrintColumns by_print = PrintColumns::Zero();
  const Parameters h = geometry.parameters();
  // A wider board has more of the plane in a cell: the homography's first column grows.
  for (int axis = 0; axis < 2; ++axis)
    for (int row = 0; row * 3 + axis < BoardGeometry::kParameters; ++row)
      by_print(row * 3 + axis, axis) = tolerance.scale * h[row * 3 + axis];
  if (tolerance.register_m == 0) return by_print;
  const PulledCorners pulled(geometry, size, saturated);
  for (int axis = 0; axis < 2; ++axis)
    by_print.col(2 + axis) = tolerance.register_m / cell_m[axis] * pulled.Along(axis);
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
