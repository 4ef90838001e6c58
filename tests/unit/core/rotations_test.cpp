#include "core/rotations.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "chequer/geometry.h"

namespace chequer {
namespace {

void ExpectTakes(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Quaterniond rotation = RotationBetween(from, to);
  EXPECT_NEAR(rotation.norm(), 1, 1e-12);
  EXPECT_LT((rotation * from.normalized() - to.normalized()).norm(), 1e-6)
      << from.transpose() << " to " << to.transpose();
}

TEST(RotationBetween, TakesADirectionToAnother) {
  const Eigen::Vector3d from(0.3, -2, 0.7), across = from.unitOrthogonal();
  ExpectTakes(from, {1, 5, -2});
  ExpectTakes(from, 3 * from);
  ExpectTakes(from, -from);
  ExpectTakes(from, -from + 1e-9 * across);
  ExpectTakes(from, -from + 1e-4 * across);
}

TEST(RotationBetween, IsTheShortest) {
  const Eigen::Vector3d from(0.3, -2, 0.7), to(1, 5, -2);
  const Eigen::Vector3d axis = VectorFromRotation(RotationBetween(from, to));
  EXPECT_NEAR(axis.dot(from), 0, 1e-12);
  EXPECT_NEAR(axis.dot(to), 0, 1e-12);
}

TEST(NearestRotation, FindsTheRotationOfAStretchedOne) {
  const Eigen::Matrix3d rotation = RotationFromVector({0.4, -1.1, 0.3}).toRotationMatrix();
  const Eigen::Vector3d scales(3, 2, 0.5);
  const NearestRotation found = FindNearestRotation(rotation * scales.asDiagonal());
  EXPECT_LT((found.rotation - rotation).norm(), 1e-12);
  EXPECT_LT((found.scales - scales).norm(), 1e-12);
}

TEST(NearestRotation, IsNoMirror) {
  const Eigen::Matrix3d rotation = RotationFromVector({0.4, -1.1, 0.3}).toRotationMatrix();
  const NearestRotation found = FindNearestRotation(rotation * Eigen::Vector3d(3, 2, -0.5).asDiagonal());
  EXPECT_LT((found.rotation - rotation).norm(), 1e-12);
}

}  // namespace
}  // namespace chequer
