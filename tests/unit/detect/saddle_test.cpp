#include "detect/corners/saddle.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <functional>

#include "support/targets.h"

namespace chequer {
namespace {

constexpr int kSide = 24;
/// Where four cells meet, between pixels.
constexpr double kMiddle = 11.5;
constexpr std::uint8_t kLight = 210, kDark = 50;
constexpr float kContrast = kLight - kDark;

/// A plane with a value for every offset from the middle.
BytePlane Draw(const std::function<std::uint8_t(double, double)>& value) {
  BytePlane plane;
  plane.Resize(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) plane.row(y)[x] = value(x - kMiddle, y - kMiddle);
  return plane;
}

/// Four cells, light where both offsets along the turned axes have one sign.
BytePlane FourCells(double angle_rad = 0) {
  return Draw([=](double x, double y) {
    const double u = std::cos(angle_rad) * x + std::sin(angle_rad) * y,
                 v = std::cos(angle_rad) * y - std::sin(angle_rad) * x;
    return (u > 0) == (v > 0) ? kLight : kDark;
  });
}

/// Of a response that is the same at the pixel to the left and above: the peak lies between them.
Peak PeakAt(int x, int y, std::uint8_t response = 80) {
  return {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), response, response, 0, response, 0};
}

struct Found {
  std::vector<Corner> corners;
  std::vector<RefusedPeak> refused;
};

Found Find(const BytePlane& plane, std::span<const Peak> peaks, float least_contrast = 0) {
  Found found;
  AppendSaddles(plane, peaks, found.corners, found.refused, least_contrast);
  return found;
}

Found Find(const BytePlane& plane, const Peak& peak, float least_contrast = 0) {
  return Find(plane, std::span(&peak, 1), least_contrast);
}

TEST(AppendSaddles, TellsWhereFourCellsMeet) {
  const Found found = Find(FourCells(), PeakAt(12, 12));
  ASSERT_EQ(found.corners.size(), 1u);
  EXPECT_TRUE(found.refused.empty());
  const Corner& corner = found.corners[0];
  EXPECT_NEAR(corner.position.x(), kMiddle, 0.01);
  EXPECT_NEAR(corner.position.y(), kMiddle, 0.01);
  EXPECT_NEAR(corner.contrast, kContrast, 1);
  EXPECT_FALSE(corner.ridge);
  EXPECT_EQ(corner.scale, 1);
}

TEST(AppendSaddles, HasALightSectorFromRay0ToRay1) {
  for (const double angle_rad : {0.0, 0.3, 0.7, 1.0, 1.4, 2.0, 3.0}) {
    SCOPED_TRACE(angle_rad);
    const Found found = Find(FourCells(angle_rad), PeakAt(12, 12));
    ASSERT_EQ(found.corners.size(), 1u);
    const std::array<Eigen::Vector2f, 4>& rays = found.corners[0].rays;
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(rays[k].norm(), 1, 1e-5);
      EXPECT_NEAR((rays[k] + rays[(k + 2) % 4]).norm(), 0, 1e-5);
    }
    // The light sector begins along u, by growing angle; the ring tells its angle to some 12 degrees.
    const Eigen::Vector2f u(static_cast<float>(std::cos(angle_rad)), static_cast<float>(std::sin(angle_rad)));
    EXPECT_GT(std::abs(rays[0].dot(u)), 0.97f);
    EXPECT_GT(rays[0].x() * rays[1].y() - rays[0].y() * rays[1].x(), 0.9f);
  }
}

TEST(AppendSaddles, TellsCornersOnRidges) {
  const BytePlane plane = Draw([](double x, double y) {
    if (std::hypot(x, y) < 2) return kLight;
    return (x > 0) == (y > 0) ? kLight : kDark;
  });
  const Found found = Find(plane, PeakAt(12, 12));
  ASSERT_EQ(found.corners.size(), 1u);
  EXPECT_TRUE(found.corners[0].ridge);
}

TEST(AppendSaddles, RefusesEdgesAndCornersOfOneCellAndFlatGround) {
  const BytePlane edge = Draw([](double x, double) { return x > 0 ? kLight : kDark; });
  EXPECT_TRUE(Find(edge, PeakAt(12, 12)).corners.empty());
  const BytePlane corner = Draw([](double x, double y) { return x > 0 && y > 0 ? kLight : kDark; });
  EXPECT_TRUE(Find(corner, PeakAt(12, 12)).corners.empty());
  const BytePlane flat = Draw([](double, double) { return kLight; });
  EXPECT_TRUE(Find(flat, PeakAt(12, 12)).corners.empty());
}

TEST(AppendSaddles, RefusesEdgesThatAreNotInLine) {
  // Three narrow cells and a wide one: opposite edges bend by 60 degrees.
  const BytePlane bent = Draw([](double x, double y) {
    const double angle = std::atan2(y, x) * 180 / M_PI + 180;
    return (angle < 60) || (angle > 120 && angle < 180) ? kLight : kDark;
  });
  const Found found = Find(bent, PeakAt(12, 12));
  EXPECT_TRUE(found.corners.empty());
  EXPECT_EQ(found.refused.size(), 1u);
}

TEST(AppendSaddles, RefusesAResponseThatIsTooWeakForTheContrast) {
  EXPECT_EQ(Find(FourCells(), PeakAt(12, 12, 17)).corners.size(), 1u);
  EXPECT_TRUE(Find(FourCells(), PeakAt(12, 12, 15)).corners.empty());
}

TEST(AppendSaddles, TellsWhichPeaksWithContrastItRefused) {
  const BytePlane edge = Draw([](double x, double) { return x > 0 ? kLight : kDark; });
  const std::vector<Peak> peaks{PeakAt(4, 12), PeakAt(12, 12), PeakAt(12, 6)};  // the first on flat ground
  const Found found = Find(edge, peaks, 30);
  ASSERT_EQ(found.refused.size(), 2u);
  EXPECT_EQ(found.refused[0].index, 1u);
  EXPECT_EQ(found.refused[1].index, 2u);
  EXPECT_NEAR(found.refused[0].contrast, kContrast, 1);
  EXPECT_TRUE(Find(edge, peaks, kContrast + 1).refused.empty());
}

TEST(AppendSaddles, KeepsTheOrderOfPeaksAndWhatWasThere) {
  // A checkerboard with more corners than fit into the longest vectors, and not a multiple of them; every third
  // peak lies on an edge.
  constexpr int kCheck = 8, kAcross = 9, kDown = 5;
  BytePlane plane;
  plane.Resize(kCheck * kAcross, kCheck * kDown);
  for (int y = 0; y < plane.height(); ++y)
    for (int x = 0; x < plane.width(); ++x) plane.row(y)[x] = (x / kCheck + y / kCheck) % 2 == 0 ? kLight : kDark;
  std::vector<Peak> peaks;
  for (int row = 1; row < kDown; ++row)
    for (int col = 1; col < kAcross; ++col) {
      const int off = peaks.size() % 3 == 2 ? kCheck / 2 : 0;
      peaks.push_back(PeakAt(col * kCheck + off, row * kCheck));
    }
  peaks.pop_back();
  std::vector<Corner> corners(1);
  corners[0].contrast = 7;
  corners[0].position = {static_cast<float>(kCheck) - 0.5f, static_cast<float>(kCheck) - 0.5f};  // of another plane
  std::vector<RefusedPeak> refused(5);
  AppendSaddles(plane, peaks, corners, refused, 0);
  EXPECT_EQ(corners[0].contrast, 7);
  ASSERT_EQ(refused.size(), peaks.size() / 3);
  EXPECT_EQ(refused[0].index, 2u);
  for (std::size_t i = 1; i < refused.size(); ++i) EXPECT_EQ(refused[i].index, refused[i - 1].index + 3);
  ASSERT_EQ(corners.size(), 1 + peaks.size() - refused.size());
  for (std::size_t i = 0, corner = 1; i < peaks.size(); ++i) {
    if (i % 3 == 2) continue;
    EXPECT_NEAR(corners[corner].position.x(), peaks[i].x - 0.5, 0.01);
    EXPECT_NEAR(corners[corner++].position.y(), peaks[i].y - 0.5, 0.01);
  }
}

TEST(AppendSaddles, TakesTwoPeaksForOneCornerBetweenThem) {
  const BytePlane plane = FourCells();
  // Their parabolas' tops lie half a pixel to the left and above.
  for (const auto& [x, y] : {std::pair{11, 12}, {12, 11}}) {
    const Found found = Find(plane, std::vector{PeakAt(x, y), PeakAt(12, 12)});
    ASSERT_EQ(found.corners.size(), 1u);
    EXPECT_NEAR(found.corners[0].position.x(), 0.5 * (x + 12) - 0.5, 0.01);
    EXPECT_NEAR(found.corners[0].position.y(), 0.5 * (y + 12) - 0.5, 0.01);
  }
}

TEST(AppendSaddles, FindsTheSameWithEveryInstructionSet) {
  const BytePlane plane = FourCells(0.4);
  std::vector<Peak> peaks;
  for (int y = 4; y < 20; y += 2)
    for (int x = 4; x < 20; x += 2) peaks.push_back(PeakAt(x, y));
  const Found expected = Find(plane, peaks);
  EXPECT_FALSE(expected.corners.empty());
  for (const std::int64_t target : test::AllTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    const Found found = Find(plane, peaks);
    hwy::SetSupportedTargetsForTest(0);
    ASSERT_EQ(found.corners.size(), expected.corners.size());
    ASSERT_EQ(found.refused.size(), expected.refused.size());
    for (std::size_t i = 0; i < found.corners.size(); ++i) {
      EXPECT_LT((found.corners[i].position - expected.corners[i].position).norm(), 1e-4);
      EXPECT_LT((found.corners[i].rays[0] - expected.corners[i].rays[0]).norm(), 1e-4);
      EXPECT_EQ(found.corners[i].ridge, expected.corners[i].ridge);
    }
  }
}

}  // namespace
}  // namespace chequer
