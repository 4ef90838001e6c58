#include "robot/body_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "detect/common/widened.h"
#include "detect/pose/plane_pose.h"
#include "support/dense.h"
#include "support/seed.h"
#include "unit/robot/measured_boards.h"

namespace chequer {
namespace {

using test::Measure;
using test::OnFloor;
using test::WorldFromCamera;

constexpr double kHeight = 0.1;

RigidTransform CameraFromWorld() { return WorldFromCamera().Inverse(); }

/// A marker that lies a little off the middle of its body.
RigidTransform Mount() { return {RotationFromVector({0, 0, 0.4}), {0.03, -0.01, kHeight}}; }
/// One that leans.
RigidTransform LeaningMount() { return {RotationFromVector({0.3, 0.2, -1}), {-0.08, 0.02, 0.15}}; }

MountedBoard See(const RigidTransform& world_from_body, const RigidTransform& body_from_marker,
                 std::mt19937_64* random = nullptr) {
  return {Measure(CameraFromWorld() * world_from_body * body_from_marker, random), body_from_marker};
}

double HeadingError(double a, double b) { return std::remainder(a - b, 2 * std::numbers::pi); }

TEST(FitBodyOnFloor, FindsTheTruePlace) {
  std::mt19937_64 random = test::SeededGenerator();
  std::uniform_real_distribution<double> place(-0.8, 0.8), turn(-std::numbers::pi, std::numbers::pi);
  for (int i = 0; i < 100; ++i) {
    const double x = place(random), y = place(random), heading = turn(random);
    const RigidTransform truth = OnFloor(x, y, heading, 0.05);
    const std::vector boards{See(truth, i % 2 == 0 ? Mount() : LeaningMount())};
    // From a bad start: 10 cm and 30 degrees away.
    const auto fit = FitBodyOnFloor(boards, CameraFromWorld(), 0.05, OnFloor(x + 0.1, y - 0.05, heading + 0.5));
    ASSERT_TRUE(fit.has_value()) << i;
    EXPECT_LT((fit->position - Eigen::Vector2d(x, y)).norm(), 1e-6) << i;
    EXPECT_NEAR(HeadingError(fit->heading_rad, heading), 0, 1e-6) << i;
    EXPECT_NEAR(fit->chi_square, 0, 1e-6) << i;
  }
}

TEST(FitBodyOnFloor, ItsCovarianceIsHonestAndItsErrorsSmallerThanTheFreePoses) {
  std::mt19937_64 random = test::SeededGenerator();
  const RigidTransform truth = OnFloor(0.3, 0.2, 1.2);
  double sum = 0, chi_square = 0, floor_error = 0, free_error = 0, floor_turn = 0, free_turn = 0;
  constexpr int kRuns = 400;
  for (int i = 0; i < kRuns; ++i) {
    const std::vector boards{See(truth, Mount(), &random)};
    const auto fit = FitBodyOnFloor(boards, CameraFromWorld(), 0, truth);
    const auto free = FitFreeBody(boards, CameraFromWorld() * truth);
    ASSERT_TRUE(fit && free);
    const Eigen::Vector3d error(fit->position.x() - 0.3, fit->position.y() - 0.2, HeadingError(fit->heading_rad, 1.2));
    sum += test::SquareOver(error, fit->covariance) / 3;
    chi_square += fit->chi_square - free->chi_square;
    const RigidTransform world_from_body = WorldFromCamera() * free->camera_from_body;
    floor_error += error.head<2>().squaredNorm();
    free_error += (world_from_body.translation - truth.translation).squaredNorm();
    floor_turn += error.z() * error.z();
    free_turn += VectorFromRotation(world_from_body.rotation * truth.rotation.conjugate()).squaredNorm();
  }
  EXPECT_NEAR(sum / kRuns, 1, 0.15);
  EXPECT_NEAR(chi_square / kRuns, 3, 0.5) << "three numbers less to explain with";
  EXPECT_LT(floor_error, 0.1 * free_error);
  EXPECT_LT(floor_turn, 0.5 * free_turn);
}

TEST(FitFreeBody, FindsTheTruePoseFromOneOrTwoMarkers) {
  const RigidTransform truth = {RotationFromVector({0.2, -0.1, 2}), {0.1, 0.3, 0.2}};
  const RigidTransform start = CameraFromWorld() * RigidTransform{RotationFromVector({0, 0, 2.1}), {0.12, 0.28, 0.25}};
  const std::vector both{See(truth, Mount()), See(truth, LeaningMount())};
  for (const std::size_t count : {1u, 2u}) {
    const auto fit = FitFreeBody(std::span(both).first(count), start);
    ASSERT_TRUE(fit.has_value());
    const RigidTransform error = fit->camera_from_body.Inverse() * (CameraFromWorld() * truth);
    EXPECT_LT(error.translation.norm(), 1e-6);
    EXPECT_LT(VectorFromRotation(error.rotation).norm(), 1e-6);
    EXPECT_NEAR(fit->chi_square, 0, 1e-6);
  }
}

/// Of a pose, as its covariance has it.
Eigen::Matrix<double, 6, 1> ErrorOf(const RigidTransform& found, const RigidTransform& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error << found.translation - truth.translation, VectorFromRotation(found.rotation * truth.rotation.conjugate());
  return error;
}

TEST(FitFreeBody, TheCovarianceOfTwoMarkersIsHonest) {
  std::mt19937_64 random = test::SeededGenerator();
  const RigidTransform truth = CameraFromWorld() * RigidTransform{RotationFromVector({0.2, -0.1, 2}), {0.1, 0.3, 0.2}};
  double sum = 0;
  constexpr int kRuns = 300;
  for (int i = 0; i < kRuns; ++i) {
    const std::vector boards{See(WorldFromCamera() * truth, Mount(), &random),
                             See(WorldFromCamera() * truth, LeaningMount(), &random)};
    const auto fit = FitFreeBody(boards, truth);
    ASSERT_TRUE(fit.has_value());
    const Eigen::Matrix<double, 6, 1> error = ErrorOf(fit->camera_from_body, truth);
    sum += test::SquareOver(error, fit->covariance) / 6;
  }
  EXPECT_NEAR(sum / kRuns, 1, 0.15);
}

TEST(FitFreeBody, AllMarkersOfACameraErrByTheSameCalibration) {
  std::mt19937_64 random = test::SeededGenerator();
  std::normal_distribution<double> normal;
  const RigidTransform truth = CameraFromWorld() * RigidTransform{RotationFromVector({0.2, -0.1, 2}), {0.1, 0.3, 0.2}};
  // One principal point for all, 0.2 px off to a side: all points of the plane move alike.
  const auto by_principal_point = [](const BoardMeasurement& board) {
    BoardGeometry::Parameters by = BoardGeometry::Parameters::Zero();
    by.head<3>() = 0.2 * board.plane_from_board.row(2).transpose();
    return by;
  };
  double sum = 0, side = 0;
  constexpr int kRuns = 300;
  for (int i = 0; i < kRuns; ++i) {
    std::vector boards{See(WorldFromCamera() * truth, Mount(), &random),
                       See(WorldFromCamera() * truth, LeaningMount(), &random)};
    const double off = normal(random);
    for (MountedBoard& mounted : boards) {
      BoardMeasurement& board = mounted.board;
      board.by_camera.col(0) = by_principal_point(board);
      BoardGeometry geometry(board.plane_from_board);
      geometry.Add(off * board.by_camera.col(0));
      board.plane_from_board = geometry.plane_from_board();
      board.information = Widened(board.information, board.by_camera);
    }
    const auto fit = FitFreeBody(boards, truth);
    ASSERT_TRUE(fit.has_value());
    const Eigen::Matrix<double, 6, 1> error = ErrorOf(fit->camera_from_body, truth);
    sum += test::SquareOver(error, fit->covariance) / 6;
    // With a principal point of its own for each board, the variance would be half as large.
    side += error.x() * error.x() / fit->covariance(0, 0);
    EXPECT_GT(fit->print_covariance(0, 0), 0.9 * fit->covariance(0, 0)) << "it stays from frame to frame";
  }
  EXPECT_NEAR(sum / kRuns, 1, 0.15);
  EXPECT_NEAR(side / kRuns, 1, 0.3);
}

TEST(ChiSquare, IsInfiniteBehindTheCamera) {
  const std::vector boards{See(OnFloor(0, 0, 0), Mount())};
  EXPECT_TRUE(std::isinf(ChiSquare(boards, {Eigen::Quaterniond::Identity(), {0, 0, -1}})));
  EXPECT_FALSE(FitFreeBody(boards, {Eigen::Quaterniond::Identity(), {0, 0, -1}}).has_value());
}

}  // namespace
}  // namespace chequer
