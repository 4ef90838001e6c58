#pragma once

#include <Eigen/Core>

#include "detect/common/board_geometry.h"

namespace chequer {

/// Inverse of a covariance that was the inverse of `information` and is larger by B Bᵀ now: column by column (Sherman
/// and Morrison 1950).
template <int kColumns>
BoardGeometry::Information Widened(BoardGeometry::Information information,
                                   const Eigen::Matrix<double, BoardGeometry::kParameters, kColumns>& by) {
  for (int column = 0; column < kColumns; ++column) {
    const BoardGeometry::Parameters weighted = information * by.col(column);
    information -= weighted * weighted.transpose() / (1 + weighted.dot(by.col(column)));
  }
  return information;
}

}  // namespace chequer
