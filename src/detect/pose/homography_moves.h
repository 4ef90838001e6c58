#pragma once

#include <Eigen/Core>

#include "core/small_cholesky.h"
#include "detect/common/board_geometry.h"

namespace chequer {

/// How a homography's parameters follow small moves of the plane that are smooth over a board: by least squares over
/// nine points, the middle and those of the rim of its corners. @param moves the moves of a board point, plane units: a
/// column each.
template <int kMoves, class Moves>
Eigen::Matrix<double, BoardGeometry::kParameters, kMoves> HomographyByMoves(const BoardGeometry& geometry,
                                                                            MarkerSize size, const Moves& moves) {
  constexpr int kRows = 18;
  const Eigen::Vector2d reach(0.5 * size.cols - 1, 0.5 * size.rows - 1);
  Eigen::Matrix<double, kRows, BoardGeometry::kParameters> by_parameters;
  Eigen::Matrix<double, kRows, kMoves> moved;
  for (int point = 0; point < 9; ++point) {
    const Eigen::Vector2d board(reach.x() * (point % 3 - 1), reach.y() * (point / 3 - 1));
    by_parameters.template middleRows<2>(2 * point) = geometry.PlaneByParameters(board);
    moved.template middleRows<2>(2 * point) = moves(board);
  }
  const SmallCholesky<BoardGeometry::kParameters> factor(by_parameters.transpose() * by_parameters);
  return factor.SolveEach(by_parameters.transpose() * moved);
}

}  // namespace chequer
