#pragma once

#include <Eigen/Cholesky>

#include "detect/common/board_geometry.h"

namespace chequer {

/// Inverse of a covariance that was the inverse of `information` and is larger by B Bᵀ now (Woodbury).
template <int kColumns>
BoardGeometry::Information Widened(const BoardGeometry::Information& information,
                                   const Eigen::Matrix<double, BoardGeometry::kParameters, kColumns>& by) {
  using Square = Eigen::Matrix<double, kColumns, kColumns>;
  const Eigen::Matrix<double, BoardGeometry::kParameters, kColumns> weighted = information * by;
  const Square inner = Square::Identity() + by.transpose() * weighted;
  return information - weighted * inner.llt().solve(weighted.transpose());
}

}  // namespace chequer
