#include "simulate/coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace chequer {
namespace {

/// Coverage of a polygon (down the left side, up the right one), row by row.
std::vector<double> Coverage(const std::vector<Eigen::Vector2d>& corners, int width, int height,
                             const Eigen::Vector2d& origin = {0, 0}, double scale = 1) {
  CoverageRaster raster;
  raster.Reset(width, height);
  for (std::size_t i = 0; i < corners.size(); ++i)
    raster.Add({corners[i], corners[(i + 1) % corners.size()], Eigen::Array4f(0, 0, 0, 1)}, origin, scale);
  std::vector<double> out;
  for (int y = 0; y < height; ++y)
    for (const Eigen::Array4f& cell : raster.IntegrateRow(y)) out.push_back(static_cast<double>(cell[3]));
  return out;
}

std::vector<Eigen::Vector2d> Rotated(double cx, double cy, double half, double angle) {
  std::vector<Eigen::Vector2d> corners;
  for (const auto& [x, y] : {std::pair{-1, -1}, {-1, 1}, {1, 1}, {1, -1}})
    corners.emplace_back(cx + half * (x * std::cos(angle) - y * std::sin(angle)),
                         cy + half * (x * std::sin(angle) + y * std::cos(angle)));
  return corners;
}

TEST(CoverageRaster, UprightRectangleCoversItsSharesOfPixels) {
  const auto c = Coverage({{1.25, 0.5}, {1.25, 2.25}, {3.75, 2.25}, {3.75, 0.5}}, 5, 4);
  const double columns[] = {0, 0.75, 1, 0.75, 0}, rows[] = {0.5, 1, 0.25, 0};
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < 5; ++x) EXPECT_NEAR(c[y * 5 + x], rows[y] * columns[x], 1e-6) << x << ", " << y;
}

TEST(CoverageRaster, DiagonalHalvesAPixel) {
  const auto c = Coverage({{1, 1}, {1, 2}, {2, 2}}, 3, 3);
  EXPECT_NEAR(c[4], 0.5, 1e-6);
  double sum = 0;
  for (const double value : c) sum += value;
  EXPECT_NEAR(sum, 0.5, 1e-6);
}

TEST(CoverageRaster, AreaAndCentreOfTurnedSquaresAreExact) {
  constexpr int kScale = 8, kSide = 30 * kScale;
  for (int i = 0; i < 40; ++i) {
    const double angle = 0.157 * i, cx = 10 + 0.137 * i, cy = 11 - 0.071 * i, half = 1.5 + 0.1 * i;
    const auto c = Coverage(Rotated(cx, cy, half, angle), kSide, kSide, {0, 0}, kScale);
    double area = 0, mx = 0, my = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const double value = c[static_cast<std::size_t>(y * kSide + x)];
        EXPECT_GT(value, -1e-5);
        EXPECT_LT(value, 1 + 1e-5);
        area += value / (kScale * kScale);
        mx += value * (x + 0.5) / (kScale * kScale * kScale);
        my += value * (y + 0.5) / (kScale * kScale * kScale);
      }
    EXPECT_NEAR(area, 4 * half * half, 1e-4 * area) << "angle " << angle;
    // Taking a partly covered cell's middle for its part's is off by less than this.
    EXPECT_NEAR(mx / area, cx, 3e-4) << "angle " << angle;
    EXPECT_NEAR(my / area, cy, 3e-4) << "angle " << angle;
  }
}

TEST(CoverageRaster, EachPixelMatchesFineSampling) {
  const auto corners = Rotated(5.3, 4.7, 3.1, 0.4);
  const auto c = Coverage(corners, 11, 10);
  constexpr int kFine = 100;
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 11; ++x) {
      int inside = 0;
      for (int i = 0; i < kFine * kFine; ++i) {
        const double px = x + (i % kFine + 0.5) / kFine - 5.3, py = y + (i / kFine + 0.5) / kFine - 4.7;
        const double u = px * std::cos(0.4) + py * std::sin(0.4), v = -px * std::sin(0.4) + py * std::cos(0.4);
        inside += std::abs(u) < 3.1 && std::abs(v) < 3.1;
      }
      EXPECT_NEAR(c[static_cast<std::size_t>(y * 11 + x)], inside / double{kFine * kFine}, 2e-3) << x << ", " << y;
    }
}

TEST(CoverageRaster, NeighboursLeaveNoSeam) {
  const Eigen::Vector2d a(0.3, 0.2), b(6.1, 0.9), c(5.4, 6.7), d(0.9, 5.8), middle(2.77, 3.31);
  const auto whole = Coverage({a, d, c, b}, 8, 8);
  std::vector<double> sum(64, 0.0);
  for (const auto& part : {std::vector{a, d, middle}, {d, c, middle}, {c, b, middle}, {b, a, middle}}) {
    const auto piece = Coverage(part, 8, 8);
    for (std::size_t i = 0; i < 64; ++i) sum[i] += piece[i];
  }
  for (std::size_t i = 0; i < 64; ++i) EXPECT_NEAR(sum[i], whole[i], 1e-5) << i;
}

TEST(CoverageRaster, WhatLiesBeyondTheRasterIsCutOffExactly) {
  // The same polygon seen through a window equals that part of the whole.
  const auto corners = Rotated(14.2, 13.6, 9.3, 0.7);
  const auto whole = Coverage(corners, 30, 30);
  const auto window = Coverage(corners, 9, 7, {11, 8});
  for (std::size_t y = 0; y < 7; ++y)
    for (std::size_t x = 0; x < 9; ++x) EXPECT_NEAR(window[y * 9 + x], whole[(y + 8) * 30 + x + 11], 1e-5);
}

TEST(CoverageRaster, ScaleDividesPixels) {
  const auto corners = Rotated(3.1, 2.9, 1.7, 0.3);
  const auto coarse = Coverage(corners, 6, 6);
  const auto fine = Coverage(corners, 24, 24, {0, 0}, 4);
  for (std::size_t y = 0; y < 6; ++y)
    for (std::size_t x = 0; x < 6; ++x) {
      double mean = 0;
      for (std::size_t i = 0; i < 16; ++i) mean += fine[(4 * y + i / 4) * 24 + 4 * x + i % 4] / 16;
      EXPECT_NEAR(mean, coarse[y * 6 + x], 1e-5);
    }
}

}  // namespace
}  // namespace chequer
