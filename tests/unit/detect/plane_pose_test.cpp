#include "detect/plane_pose.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace chequer {
namespace {

std::vector<PointPair> Seen(const RigidTransform& camera_from_board) {
  std::vector<PointPair> pairs;
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x)
      pairs.push_back({Eigen::Vector2d(0.02 * x, 0.02 * y),
                       (camera_from_board * Eigen::Vector3d(0.02 * x, 0.02 * y, 0)).hnormalized()});
  return pairs;
}

TEST(PlanePoses, TheFirstIsTheTruePose) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> tilt(-0.8, 0.8), turn(-3, 3), place(-0.3, 0.3);
  for (int i = 0; i < 200; ++i) {
    const RigidTransform truth{
        RotationFromVector({tilt(random), tilt(random), 0}) * RotationFromVector({0, 0, turn(random)}),
        {place(random), place(random), 1}};
    const std::vector<PointPair> pairs = Seen(truth);
    const auto homography = FitHomography(pairs);
    ASSERT_TRUE(homography.has_value());
    const auto poses = PlanePoses(*homography, pairs);
    ASSERT_TRUE(poses.has_value()) << "case " << i;
    const RigidTransform& found = (*poses)[0].camera_from_board;
    EXPECT_LT((found.translation - truth.translation).norm(), 1e-6) << "case " << i;
    EXPECT_LT(VectorFromRotation(found.rotation * truth.rotation.conjugate()).norm(), 1e-5) << "case " << i;
    EXPECT_GE((*poses)[1].square_error, (*poses)[0].square_error);
  }
}

TEST(PlanePoses, AMirroredPlaneHasNone) {
  std::vector<PointPair> pairs = Seen({RotationFromVector({0.2, 0.1, 0}), {0, 0, 1}});
  for (PointPair& pair : pairs) pair.from.x() = -pair.from.x();
  EXPECT_FALSE(PlanePoses(*FitHomography(pairs), pairs).has_value());
}

TEST(FitHomography, PointsOnALineDetermineNone) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < 6; ++i) pairs.push_back({Eigen::Vector2d(i, 2 * i), Eigen::Vector2d(3 * i, i)});
  EXPECT_FALSE(FitHomography(pairs).has_value());
  EXPECT_FALSE(FitHomography(std::span(pairs).first(3)).has_value());
}

}  // namespace
}  // namespace chequer
