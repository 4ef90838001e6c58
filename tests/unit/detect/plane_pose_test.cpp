#include "detect/pose/plane_pose.h"

#include <gtest/gtest.h>

#include <random>

#include "support/board_places.h"
#include "support/dense.h"

namespace chequer {
namespace {

constexpr double kCell = 0.02, kFocal = 900, kDeviationPx = 0.02;

RigidTransform RandomPose(std::mt19937& random, double least_tilt, double distance) {
  std::uniform_real_distribution<double> tilt(least_tilt, 0.9), turn(-3, 3), place(-0.3, 0.3);
  const double direction = turn(random), angle = tilt(random);
  return {RotationFromVector({angle * std::cos(direction), angle * std::sin(direction), 0}) *
              RotationFromVector({0, 0, turn(random)}),
          {distance * place(random), distance * place(random), distance}};
}

/// The homography of a pose, and the information of 25 corners that are known to kDeviationPx.
MeasuredHomography Seen(const RigidTransform& camera_from_board) {
  const BoardGeometry geometry = test::PlaceOf(camera_from_board, {kCell, kCell}, kFocal);
  return {geometry, test::InformationOfCorners(geometry, kDeviationPx)};
}

MeasuredHomography WithNoise(MeasuredHomography measured, std::mt19937& random) {
  std::normal_distribution<double> normal;
  BoardGeometry::Parameters white;
  for (double& value : white) value = normal(random);
  measured.geometry.Add(test::WithInformation(measured.information, white));
  return measured;
}

Eigen::Matrix<double, 6, 1> Error(const RigidTransform& found, const RigidTransform& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error << found.translation - truth.translation,
      VectorFromRotation((found.rotation * truth.rotation.conjugate()).normalized());
  return error;
}

TEST(PlanePoses, TheFirstIsTheTruePose) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    const RigidTransform truth = RandomPose(random, 0, 1);
    const auto poses = PlanePoses(Seen(truth), {kCell, kCell}, kFocal);
    ASSERT_TRUE(poses.has_value()) << "case " << i;
    EXPECT_LT(Error((*poses)[0].camera_from_board, truth).norm(), 1e-5) << "case " << i;
    EXPECT_GE((*poses)[1].chi_square, (*poses)[0].chi_square) << "case " << i;
  }
}

TEST(PlanePoses, TheCovarianceIsThatOfTheErrors) {
  std::mt19937 random(7);
  double normalised = 0, chi_square = 0;
  constexpr int kCases = 400;
  for (int i = 0; i < kCases; ++i) {
    const RigidTransform truth = RandomPose(random, 0.4, 0.6);
    const auto poses = PlanePoses(WithNoise(Seen(truth), random), {kCell, kCell}, kFocal);
    ASSERT_TRUE(poses.has_value()) << "case " << i;
    const auto error = Error((*poses)[0].camera_from_board, truth);
    normalised += test::SquareOver(error, (*poses)[0].covariance);
    chi_square += (*poses)[0].chi_square;
  }
  EXPECT_NEAR(normalised / kCases, 6, 0.6) << "squares of the errors by the covariance: six degrees of freedom";
  EXPECT_NEAR(chi_square / kCases, 2, 0.3) << "of the homography's eight, two are left over";
}

TEST(PlanePoses, TheSecondIsTheMirroredPoseAndIsLikelierTheFartherTheBoard) {
  std::mt19937 random(9);
  const RigidTransform near = RandomPose(random, 0.5, 0.5);
  RigidTransform far = near;
  far.translation *= 60;
  const auto near_poses = PlanePoses(Seen(near), {kCell, kCell}, kFocal),
             far_poses = PlanePoses(Seen(far), {kCell, kCell}, kFocal);
  ASSERT_TRUE(near_poses && far_poses);
  EXPECT_GT((*near_poses)[1].chi_square, 1000);
  EXPECT_LT((*far_poses)[1].chi_square, 1);
  const Eigen::Vector3d sight = far.translation.normalized(), normal = far.rotation * Eigen::Vector3d::UnitZ(),
                        mirrored = (*far_poses)[1].camera_from_board.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_LT((mirrored - (2 * normal.dot(sight) * sight - normal)).norm(), 0.05);
}

TEST(PlanePoses, AMirroredPlaneHasNone) {
  MeasuredHomography seen = Seen({RotationFromVector({0.2, 0.1, 0}), {0, 0, 1}});
  seen.geometry = BoardGeometry(seen.geometry.plane_from_board() * Eigen::Vector3d(-1, 1, 1).asDiagonal());
  EXPECT_FALSE(PlanePoses(seen, {kCell, kCell}, kFocal).has_value());
}

TEST(PlanePoses, CellsNeedNotBeSquare) {
  std::mt19937 random(11);
  for (int i = 0; i < 100; ++i) {
    const RigidTransform truth = RandomPose(random, 0, 1);
    MeasuredHomography seen = Seen(truth);
    // Printed 2 % too wide: the same pixels show a smaller part of the board's width.
    seen.geometry = BoardGeometry(seen.geometry.plane_from_board() * Eigen::Vector3d(1.02, 1, 1).asDiagonal());
    const auto poses = PlanePoses(seen, {1.02 * kCell, kCell}, kFocal);
    ASSERT_TRUE(poses.has_value()) << "case " << i;
    EXPECT_LT(Error((*poses)[0].camera_from_board, truth).norm(), 1e-5) << "case " << i;
  }
}

}  // namespace
}  // namespace chequer
