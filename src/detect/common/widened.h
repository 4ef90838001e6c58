#pragma once

#include <Eigen/Core>

#include "core/small_cholesky.h"
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

/// The same where it is larger by any covariance, or smaller by a part of what it holds.
inline BoardGeometry::Information WidenedBy(const BoardGeometry::Information& information,
                                            const BoardGeometry::Information& covariance) {
  return InverseOf<BoardGeometry::kParameters>(InverseOf(information) + covariance);
}

}  // namespace chequer
