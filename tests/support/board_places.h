#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

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

/// Where a point of a board on a cylinder is seen, plane. @param along the direction of the bend, of length 1.
inline Eigen::Vector2d SeenOnCylinder(const RigidTransform& camera_from_board, double radius_m,
                                      const Eigen::Vector2d& along, const Eigen::Vector2d& cell_m, double focal_px,
                                      const Eigen::Vector2d& board) {
  const Eigen::Vector2d printed = board.cwiseProduct(cell_m), across(-along.y(), along.x());
  const double turn = along.dot(printed) / radius_m;
  const Eigen::Vector2d on_plane = radius_m * std::sin(turn) * along + across.dot(printed) * across;
  const Eigen::Vector3d point(on_plane.x(), on_plane.y(), radius_m * (1 - std::cos(turn)));
  return focal_px * (camera_from_board.rotation * point + camera_from_board.translation).hnormalized();
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
