// Where a board may be, told by points and by what changes from pixel to pixel.
#include "detect/boards/place.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>

#include "simulate/random.h"

namespace chequer {
namespace {

/// A plane of some ground, with a value for every pixel that `of` gives one above zero.
BytePlane Draw(int width, int height, const std::function<int(Eigen::Vector2f)>& of) {
  BytePlane plane;
  plane.Resize(width, height);
  Random random(5);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int value = of({static_cast<float>(x), static_cast<float>(y)});
      plane.row(y)[x] = static_cast<std::uint8_t>(value > 0 ? value : 110 + static_cast<int>(random.Below(5)));
    }
  return plane;
}

/// A board of 6 × 6 cells of `wide` × `high` px, turned by `angle` in its own plane, then squeezed along the image's
/// direction `axis`.
BytePlane DrawBoard(const Eigen::Vector2f& middle, float wide, float high, float angle, float axis) {
  const Eigen::Rotation2D<float> by_axis(axis), by_angle(angle);
  return Draw(320, 240, [&](const Eigen::Vector2f& at) {
    const Eigen::Vector2f squeezed = by_axis.inverse() * (at - middle);
    const Eigen::Vector2f cell = by_angle.inverse() * Eigen::Vector2f(squeezed.x() / wide, squeezed.y() / high);
    if (cell.cwiseAbs().maxCoeff() > 3) return 0;
    return (static_cast<int>(std::floor(cell.x())) + static_cast<int>(std::floor(cell.y()))) % 2 == 0 ? 220 : 40;
  });
}

TEST(PlaceOfChange, LiesWhereANarrowBoardDoes) {
  const Eigen::Vector2f middle(150.3f, 118.6f);
  for (const float turned : {0.0f, 0.4f, 0.785f})
    for (const float axis : {0.0f, 0.6f, 1.3f, 2.4f})
      for (const float off : {-12.0f, 9.0f}) {
        // From a point that is not its middle.
        const Eigen::Vector2f along(std::cos(axis), std::sin(axis));
        const BytePlane plane = DrawBoard(middle, 15, 3.5f, turned, axis);
        const auto place = PlaceOfChange(plane, middle + off * along, 14);
        ASSERT_TRUE(place) << "turned by " << turned << ", squeezed across " << axis;
        EXPECT_LT((place->middle - middle).norm(), 3) << "turned by " << turned << ", squeezed across " << axis;
        EXPECT_GT(std::abs(place->axes.col(0).dot(along)), 0.995f);
        EXPECT_NEAR(place->spread[0], 15 * kSpreadCells, 3);
        EXPECT_NEAR(place->cell_px(), 3.5, 0.7);
        EXPECT_GT(place->axes.determinant(), 0) << "mirrored";
      }
}

TEST(PlaceOfChange, FollowsNeitherGroundNorLines) {
  Random random(3);
  const BytePlane ground =
      Draw(320, 240, [&](const Eigen::Vector2f&) { return 20 + static_cast<int>(random.Below(200)); });
  EXPECT_FALSE(PlaceOfChange(ground, {160, 120}, 14));
  for (const float angle : {0.1f, 0.8f, 1.5f}) {
    const Eigen::Vector2f across(-std::sin(angle), std::cos(angle));
    // As sharp as lenses draw it.
    const BytePlane line = Draw(320, 240, [&](const Eigen::Vector2f& at) {
      const float away = std::abs(across.dot(at - Eigen::Vector2f(160, 120)));
      return away < 3 ? 112 + static_cast<int>(100 * std::min(3 - away, 1.5f) / 1.5f) : 0;
    });
    EXPECT_FALSE(PlaceOfChange(line, {160, 120}, 14)) << angle;
  }
}

TEST(PlaceOfChange, StaysWithinThePlane) {
  // Nothing changes, or all of it lies at the rim, or the point outside.
  const BytePlane even = Draw(64, 48, [](const Eigen::Vector2f&) { return 128; });
  EXPECT_FALSE(PlaceOfChange(even, {20, 20}, 14));
  const BytePlane board = DrawBoard({3, 236}, 10, 3, 0.3f, 0.5f);
  for (const Eigen::Vector2f& from : {Eigen::Vector2f(0, 239), Eigen::Vector2f(-30, 260), Eigen::Vector2f(400, 5)})
    if (const auto place = PlaceOfChange(board, from, 14)) {
      EXPECT_TRUE(place->middle.allFinite());
    }
  const BytePlane smallest = Draw(2, 2, [](const Eigen::Vector2f& at) { return at.x() > 0 ? 200 : 20; });
  if (const auto place = PlaceOfChange(smallest, {1, 1}, 14)) {
    EXPECT_TRUE(place->spread.allFinite());
  }
}

TEST(GatherPoints, TakesWhatLiesWithinReach) {
  std::vector<StrongPoint> points;
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x)
      points.push_back({{100 + 10 * static_cast<float>(x), 50 + 4 * static_cast<float>(y)}, 80});
  points.push_back({{200, 50}, 80});
  Place from;
  from.middle = {95, 52};
  from.spread.setConstant(15);
  const Place place = GatherPoints(points, from);
  EXPECT_EQ(place.count, 25);
  EXPECT_LT((place.middle - Eigen::Vector2f(100, 50)).norm(), 1e-3);
  EXPECT_NEAR(place.spread[0], 10 * std::numbers::sqrt2, 0.01);
  EXPECT_NEAR(place.cell_px(), 4, 0.05);
  for (const StrongPoint& point : points) EXPECT_EQ(IsWithinReach(place, point.position), point.position.x() < 150);
  from.middle = {1000, 1000};
  EXPECT_EQ(GatherPoints(points, from).count, 0);
}

}  // namespace
}  // namespace chequer
