#include "chequer/geometry.h"

#include <gtest/gtest.h>

#include <numbers>

namespace chequer {
namespace {

TEST(RigidTransform, InverseUndoes) {
  const RigidTransform camera_from_marker{RotationFromVector({0.3, -1.2, 2.0}), {1, 2, 3}};
  const Eigen::Vector3d x_in_marker(0.1, -0.4, 0.7);
  EXPECT_LT((camera_from_marker.Inverse() * (camera_from_marker * x_in_marker) - x_in_marker).norm(), 1e-14);
  EXPECT_LT(((camera_from_marker.Inverse() * camera_from_marker) * x_in_marker - x_in_marker).norm(), 1e-14);
}

TEST(RotationVector, LogInvertsExpFromTinyToHalfATurn) {
  for (const double angle : {0.0, 1e-12, 1e-7, 1e-3, 1.0, 3.0, std::numbers::pi - 1e-6}) {
    const Eigen::Vector3d theta = angle * Eigen::Vector3d(1, -2, 2) / 3;
    EXPECT_LT((VectorFromRotation(RotationFromVector(theta)) - theta).norm(), 1e-9) << "angle " << angle;
  }
}

TEST(Canonical, TurnsTheSignToNonNegativeW) {
  const Eigen::Quaterniond q(-0.5, 0.5, 0.5, -0.5);
  EXPECT_GE(Canonical(q).w(), 0);
  EXPECT_TRUE(Canonical(q).toRotationMatrix().isApprox(q.toRotationMatrix()));
}

}  // namespace
}  // namespace chequer
