#include "detect/fit/weak_bend.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "support/board_places.h"

namespace chequer {
namespace {

constexpr double kFocal = 990, kCell = 0.02, kDeviationPx = 0.01;

/// What a fit of flat paper has of a board's corners, all of them with the same noise.
struct FlatFit {
  FlatFit(const RigidTransform& camera_from_board, double radius_m) {
    BoardGeometry geometry = test::PlaceOf(camera_from_board, {kCell, kCell}, kFocal);
    BoardGeometry::Information normal;
    for (int step = 0; step < 5; ++step) {
      normal.setZero();
      BoardGeometry::Parameters gradient = BoardGeometry::Parameters::Zero();
      corners.clear();
      for (int corner = 0; corner < 25; ++corner) {
        ShiftedCorner shifted{.corner = corner, .board = CornerOnBoard({6, 6}, corner / 5, corner % 5)};
        const Eigen::Matrix2d by_board = geometry.PlaneByBoard(shifted.board);
        shifted.information = by_board.transpose() * by_board / (kDeviationPx * kDeviationPx);
        const Eigen::Vector2d seen =
            test::SeenOnCylinder(camera_from_board, radius_m, {0.8, 0.6}, {kCell, kCell}, kFocal, shifted.board);
        shifted.shift = by_board.inverse() * (geometry.ToPlane(shifted.board) - seen);
        Eigen::Matrix<double, BoardGeometry::kParameters, 2> by;
        for (int axis = 0; axis < 2; ++axis) by.col(axis) = BoardGeometry::MoveByParameters(shifted.board, axis);
        normal += by * shifted.information * by.transpose();
        gradient += by * shifted.information * shifted.shift;
        corners.push_back(shifted);
      }
      geometry.MoveCoordinates(normal.llt().solve(gradient));
    }
    measured.plane_from_board = geometry.plane_from_board();
    measured.information = test::InformationOfCorners(geometry, kDeviationPx);
    measured.focal_px = kFocal;
    measured.cell_m = measured.cell_height_m = kCell;
  }

  std::vector<ShiftedCorner> corners;
  BoardMeasurement measured;
};

PlanePose PoseOf(const BoardMeasurement& measured) {
  return (*PlanePoses({BoardGeometry(measured.plane_from_board), measured.information}, {kCell, kCell}, kFocal))[0];
}

/// Of a pose, by its covariance, over its dimensions.
double SquaredError(const PlanePose& pose, const RigidTransform& truth) {
  Eigen::Matrix<double, 6, 1> off;
  off << truth.translation - pose.camera_from_board.translation,
      VectorFromRotation(truth.rotation * pose.camera_from_board.rotation.conjugate());
  return off.dot(pose.covariance.llt().solve(off)) / 6;
}

// Taken for flat, they lie farther off than they say.
TEST(AllowForBend, MovesBoardsToWhereTheyLie) {
  for (const double radius_m : {2.5, -2.5, 1.5, -1.5, 1.0, -1.0})
    for (const double tilt : {0.3, -0.4}) {
      SCOPED_TRACE(testing::Message() << "radius " << radius_m << " tilt " << tilt);
      const RigidTransform truth{RotationFromVector({tilt, 0.1, 0.4}), {0.4, -0.25, 2}};
      const FlatFit fit(truth, radius_m);
      const PlanePose flat = PoseOf(fit.measured);
      const auto mean = AllowForBend({.corners = fit.corners}, fit.measured, flat);
      ASSERT_TRUE(mean);
      EXPECT_GT(SquaredError(flat, truth), 4);
      EXPECT_LT(SquaredError(PoseOf(*mean), truth), 1.5);
    }
}

TEST(AllowForBend, LeavesFlatBoardsAsTheyAre) {
  const FlatFit fit({RotationFromVector({0.3, 0.1, 0.4}), {0.4, -0.25, 2}}, 1e9);
  EXPECT_FALSE(AllowForBend({.corners = fit.corners}, fit.measured, PoseOf(fit.measured)));
  EXPECT_FALSE(AllowForBend({}, fit.measured, PoseOf(fit.measured)));
}

}  // namespace
}  // namespace chequer
