#include "detect/common/homography.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

namespace chequer {
namespace {

TEST(FitHomography, GoesThroughExactPoints) {
  Eigen::Matrix3d truth;
  truth << 20, 3, 300, -2, 18, 200, 0.01, -0.004, 1;
  std::vector<PointPair> pairs;
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x)
      pairs.push_back({Eigen::Vector2d(x, y), (truth * Eigen::Vector3d(x, y, 1)).hnormalized()});
  const auto homography = FitHomography(pairs);
  ASSERT_TRUE(homography.has_value());
  EXPECT_LT((*homography - truth).norm(), 1e-8);
}

TEST(FitHomography, PointsOnALineDetermineNone) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < 6; ++i) pairs.push_back({Eigen::Vector2d(i, 2 * i), Eigen::Vector2d(3 * i, i)});
  EXPECT_FALSE(FitHomography(pairs).has_value());
  EXPECT_FALSE(FitHomography(std::span(pairs).first(3)).has_value());
}

}  // namespace
}  // namespace chequer
