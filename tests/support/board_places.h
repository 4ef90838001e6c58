#pragma once

#include <Eigen/Core>

#include "chequer/geometry.h"
#include "detect/common/board_geometry.h"

namespace chequer::test {

/// Where a board of such cells is seen that stands so. @param focal_px of the plane.
inline BoardGeometry PlaceOf(const RigidTransform& camera_from_board, const Eigen::Vector2d& cell_m, double focal_px) {
  Eigen::Matrix3d plane_from_board;
  plane_from_board << camera_from_board.rotation.toRotationMatrix().leftCols<2>() * cell_m.asDiagonal(),
      camera_from_board.translation;
  plane_from_board.topRows<2>() *= focal_px;
  return BoardGeometry(plane_from_board);
}

/// The information of the 25 corners of a board there, each known to `deviation_px`.
inline BoardGeometry::Information InformationOfCorners(const BoardGeometry& geometry, double deviation_px) {
  BoardGeometry::Information information = BoardGeometry::Information::Zero();
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x) {
      const BoardGeometry::Derivative by = geometry.PlaneByParameters(Eigen::Vector2d(x, y));
      information += by.transpose() * by / (deviation_px * deviation_px);
    }
  return information;
}

}  // namespace chequer::test
