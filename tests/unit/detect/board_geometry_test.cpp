#include "detect/common/board_geometry.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace chequer {
namespace {

TEST(BoardGeometry, DerivativesAreThoseOfTheMap) {
  Eigen::Matrix3d homography;
  homography << 20, 3, 300, -2, 18, 200, 0.01, -0.004, 1;
  const BoardGeometry geometry(2 * homography);
  const Eigen::Vector2d board(1.3, -2.1);
  constexpr double h = 1e-6;
  const Eigen::Matrix2d by_board = geometry.PlaneByBoard(board);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d step = h * Eigen::Vector2d::Unit(k);
    const Eigen::Vector2d numeric = (geometry.ToPlane(board + step) - geometry.ToPlane(board - step)) / (2 * h);
    EXPECT_LT((by_board.col(k) - numeric).norm(), 1e-4) << "board coordinate " << k;
  }
  const BoardGeometry::Derivative by_parameters = geometry.PlaneByParameters(board);
  for (int k = 0; k < BoardGeometry::kParameters; ++k) {
    const BoardGeometry::Parameters step = h * BoardGeometry::Parameters::Unit(k);
    BoardGeometry plus = geometry, minus = geometry;
    plus.Add(step);
    minus.Add(-step);
    const Eigen::Vector2d numeric = (plus.ToPlane(board) - minus.ToPlane(board)) / (2 * h);
    EXPECT_LT((by_parameters.col(k) - numeric).norm(), 1e-3 * (1 + numeric.norm())) << "parameter " << k;
    EXPECT_NEAR(plus.parameters()[k] - geometry.parameters()[k], h, 1e-12) << "parameter " << k;
  }
}

TEST(BoardGeometry, MovesOfTheCoordinatesAreTheirDerivatives) {
  Eigen::Matrix3d homography;
  homography << 8, 1, 900, -1, 8, -500, 1e-3, -2e-3, 1;
  const BoardGeometry geometry(homography);
  const Eigen::Vector2d board(1.5, -2);
  for (int k = 0; k < BoardGeometry::kParameters; ++k) {
    constexpr double h = 1e-5;
    BoardGeometry moved = geometry;
    moved.MoveCoordinates(h * BoardGeometry::Parameters::Unit(k));
    const Eigen::Vector2d now =
        (moved.plane_from_board().inverse() * geometry.ToPlane(board).homogeneous()).hnormalized();
    for (int axis = 0; axis < 2; ++axis)
      EXPECT_NEAR((now - board)[axis] / h, BoardGeometry::MoveByParameters(board, axis)[k], 1e-3)
          << "parameter " << k << ", coordinate " << axis;
  }
}

TEST(BoardGeometry, InformationOnMovesIsThatOnTheHomography) {
  Eigen::Matrix3d homography;
  homography << 8, 1, 900, -1, 8, -500, 1e-3, -2e-3, 1;
  const BoardGeometry geometry(homography);
  BoardGeometry::Information of_moves = BoardGeometry::Information::Constant(0.1);
  for (int i = 0; i < BoardGeometry::kParameters; ++i) of_moves(i, i) = 1 + i;
  const BoardGeometry::Information information = geometry.FromMoves(of_moves);
  // A step of the parameters weighs as much as the move that makes it.
  for (int k = 0; k < BoardGeometry::kParameters; ++k) {
    const BoardGeometry::Parameters move =
        1e-6 * (BoardGeometry::Parameters::Unit(k) + BoardGeometry::Parameters::Constant(0.2));
    BoardGeometry moved = geometry;
    moved.MoveCoordinates(move);
    const BoardGeometry::Parameters step = moved.parameters() - geometry.parameters();
    EXPECT_NEAR(step.dot(information * step) / move.dot(of_moves * move), 1, 1e-3) << "parameter " << k;
  }
}

TEST(BoardGeometry, ParametersByMovesAreTheDerivative) {
  Eigen::Matrix3d homography;
  homography << 8, 1, 900, -1, 8, -500, 1e-3, -2e-3, 1;
  const BoardGeometry geometry(homography);
  const BoardGeometry::Information by_moves = geometry.ParametersByMoves();
  for (int k = 0; k < BoardGeometry::kParameters; ++k) {
    constexpr double h = 1e-6;
    BoardGeometry moved = geometry, back = geometry;
    moved.MoveCoordinates(h * BoardGeometry::Parameters::Unit(k));
    back.MoveCoordinates(-h * BoardGeometry::Parameters::Unit(k));
    const BoardGeometry::Parameters slope = (moved.parameters() - back.parameters()) / (2 * h);
    EXPECT_LT((by_moves.col(k) - slope).norm(), 1e-4 * slope.norm()) << "move " << k;
  }
}

TEST(BoardGeometry, MarkerAxesAreTheBoardsTurnedAboutX) {
  const RigidTransform camera_from_board{RotationFromVector({0.1, 0.2, 0.3}), {1, 2, 3}};
  const RigidTransform camera_from_marker = CameraFromMarker(camera_from_board);
  EXPECT_LT(
      (camera_from_marker * Eigen::Vector3d(0.5, -0.25, 0) - camera_from_board * Eigen::Vector3d(0.5, 0.25, 0)).norm(),
      1e-14);
}

TEST(Lens, GoesThereAndBack) {
  CameraModel camera{.width = 640, .height = 480, .fx = 540, .fy = 545, .cx = 320, .cy = 240};
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.25, 0.08, 0.001, 0, 0};
  for (const Lens& lens : {Lens(), Lens(camera)}) {
    const Eigen::Vector2d pixel(100, 400);
    const auto plane = lens.ToPlane(pixel);
    ASSERT_TRUE(plane.has_value());
    EXPECT_LT((lens.ToImage(*plane) - pixel).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace chequer
