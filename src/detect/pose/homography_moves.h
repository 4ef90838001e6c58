#pragma once

#include <Eigen/Core>

#include "core/small_cholesky.h"
#include "detect/common/board_geometry.h"

namespace chequer {

/// How a homography's parameters follow small moves of the plane: by least squares over kSide × kSide points of the
/// board, from the first to the last of its corners. Three tell moves that are smooth over a board. Those that no
/// homography is need as many as the board has corners: then it is what a fit to them makes of such moves.
/// @param moves the moves of a board point, plane units: a column each.
template <int kMoves, int kSide, class Moves>
Eigen::Matrix<double, BoardGeometry::kParameters, kMoves> HomographyByMoves(const BoardGeometry& geometry,
                                                                            MarkerSize size, const Moves& moves) {
  const Eigen::Vector2d first(1 - 0.5 * size.cols, 1 - 0.5 * size.rows), step = first / (-0.5 * (kSide - 1));
  Eigen::Matrix<double, BoardGeometry::kParameters, BoardGeometry::kParameters> square;
  Eigen::Matrix<double, BoardGeometry::kParameters, kMoves> by_moves;
  square.setZero();
  by_moves.setZero();
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col) {
      const Eigen::Vector2d board = first + step.cwiseProduct(Eigen::Vector2d(col, row));
      const BoardGeometry::Derivative by_parameters = geometry.PlaneByParameters(board);
      square += by_parameters.transpose() * by_parameters;
      by_moves += by_parameters.transpose() * moves(board);
    }
  return SmallCholesky<BoardGeometry::kParameters>(square).SolveEach(by_moves);
}

}  // namespace chequer
