#include "detect/corners/corners.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "chequer/image.h"

namespace chequer {
namespace {

constexpr int kGroundWidth = 640, kGroundHeight = 480;

/// Grey ground of random pixels around 100.
Image Ground(int most_off, unsigned seed) {
  Image image(PixelFormat::kMono8, kGroundWidth, kGroundHeight);
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> off(-most_off, most_off);
  for (std::uint8_t& pixel : image.bytes()) pixel = static_cast<std::uint8_t>(100 + off(random));
  return image;
}

/// Draws 6 × 6 cells; returns where they meet.
std::vector<Eigen::Vector2f> DrawBoard(int left, int top, int cell_px, int dark, int light, Image& image) {
  std::vector<Eigen::Vector2f> corners;
  for (int y = 0; y < 6 * cell_px; ++y)
    for (int x = 0; x < 6 * cell_px; ++x)
      image.bytes()[static_cast<std::size_t>((top + y) * kGroundWidth + left + x)] =
          static_cast<std::uint8_t>((x / cell_px + y / cell_px) % 2 == 0 ? dark : light);
  for (int row = 1; row < 6; ++row)
    for (int col = 1; col < 6; ++col)
      corners.emplace_back(static_cast<float>(left + col * cell_px) - 0.5f,
                           static_cast<float>(top + row * cell_px) - 0.5f);
  return corners;
}

int CountFound(const std::vector<Eigen::Vector2f>& places, const std::vector<Corner>& corners) {
  return static_cast<int>(std::count_if(places.begin(), places.end(), [&](const Eigen::Vector2f& place) {
    return std::any_of(corners.begin(), corners.end(),
                       [&](const Corner& corner) { return (corner.position - place).norm() < 1; });
  }));
}

TEST(FindCorners, FindsAllOfABoardOncePerPlace) {
  Image image = Ground(0, 1);
  const auto places = DrawBoard(200, 150, 10, 40, 200, image);
  Pyramid pyramid;
  std::vector<Corner> corners;
  EXPECT_GE(FindCorners(image.view(), pyramid, corners), 25);
  EXPECT_EQ(CountFound(places, corners), 25);
  EXPECT_EQ(corners.size(), 25u);
}

/// Between dark and light, half a cell's contrast at the edges: cells of `cell_px` around (x, y), turned.
BytePlane BlurredCells(double cell_px, double blur_px, double turn_rad, double x, double y) {
  constexpr int kSide = 31;
  const auto wave = [&](double at) {
    double sum = 0;
    for (int edge = -4; edge <= 4; ++edge)
      sum += (edge % 2 == 0 ? 1 : -1) * std::erf((at - edge * cell_px) / (blur_px * std::sqrt(2.0)));
    return sum;
  };
  BytePlane plane;
  plane.Resize(kSide, kSide);
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col) {
      const double dx = col - x, dy = row - y, u = std::cos(turn_rad) * dx + std::sin(turn_rad) * dy,
                   v = std::cos(turn_rad) * dy - std::sin(turn_rad) * dx;
      plane.row(row)[col] = static_cast<std::uint8_t>(std::lround(120 + 100 * wave(u) * wave(v)));
    }
  return plane;
}

void AddNoise(double levels, std::mt19937& random, BytePlane& plane) {
  std::normal_distribution<double> noise(0, levels);
  for (int y = 0; y < plane.height(); ++y)
    for (int x = 0; x < plane.width(); ++x)
      plane.row(y)[x] = static_cast<std::uint8_t>(std::clamp(plane.at(x, y) + noise(random), 0.0, 255.0));
}

TEST(PeakScan, AnswersToCornersHoweverTheyLie) {
  // Over all turns and places between pixels: at least so many of 200 grey levels (least shares as in
  // corner_response.h, less the rounding's two levels).
  struct Cells {
    double cell_px, blur_px;
    int least;
  };
  for (const Cells& cells : {Cells{8, 0.3, 72}, Cells{8, 0.5, 84}, Cells{8, 0.7, 76}, Cells{8, 1.2, 52},
                             Cells{4, 0.5, 80}, Cells{4, 0.7, 68}, Cells{4, 1.0, 46}, Cells{3.5, 0.7, 38}}) {
    int least = 255;
    for (int turn = 0; turn < 90; turn += 3)
      for (const double x : {15.0, 15.25, 15.5})
        for (const double y : {15.0, 15.25, 15.5}) {
          const BytePlane plane = BlurredCells(cells.cell_px, cells.blur_px, turn * std::numbers::pi / 180, x, y);
          PeakScan scan;
          scan.Start(plane, 5);
          scan.Advance(plane, plane.height());
          int most = 0;
          for (const Peak& peak : scan.peaks())
            if (std::hypot(peak.x - x, peak.y - y) < 1.2) most = std::max<int>(most, peak.response);
          least = std::min(least, most);
        }
    EXPECT_GE(least, cells.least) << "cells of " << cells.cell_px << " px, blur " << cells.blur_px << " px";
  }
}

TEST(FindCorners, FindsACornerOnceThoughItHasTwoPeaks) {
  PeakScan scan;
  std::vector<Corner> corners;
  std::vector<RefusedPeak> refused;
  int had_two = 0, missed = 0, drawn = 0;
  std::mt19937 random(3);
  for (const double cell_px : {4.0, 8.0})
    for (const double blur_px : {0.5, 0.7, 1.0})
      for (int turn = 0; turn < 90; turn += 3)
        for (const double x : {15.0, 15.2, 15.35, 15.5})
          for (const double y : {15.0, 15.2, 15.35, 15.5}) {
            BytePlane plane = BlurredCells(cell_px, blur_px, turn * std::numbers::pi / 180, x, y);
            AddNoise(6, random, plane);
            FindCornersIn(plane, scan, corners, refused);
            const auto count_near = [&](const auto& points, const auto& place) {
              return std::count_if(points.begin(), points.end(), [&](const auto& point) {
                const auto [px, py] = place(point);
                return std::hypot(px - x, py - y) < 1.7;
              });
            };
            had_two += count_near(scan.peaks(),
                                  [](const Peak& peak) { return std::pair<double, double>(peak.x, peak.y); }) > 1;
            const auto found = count_near(corners, [](const Corner& corner) {
              return std::pair<double, double>(corner.position.x(), corner.position.y());
            });
            ASSERT_LE(found, 1) << "cells of " << cell_px << " px, blur " << blur_px << " px, turned by " << turn
                                << " degrees, at " << x << ", " << y;
            missed += found == 0;
            ++drawn;
          }
  EXPECT_LT(missed, drawn / 100);
  EXPECT_GT(had_two, 0) << "this test is of nothing";
}

TEST(PeakScan, DoesNotAnswerToEdges) {
  for (int turn = 0; turn < 180; turn += 3)
    for (const double at : {15.0, 15.25, 15.5, 16.5, 18.0}) {
      // Far from where it meets another.
      const double radians = turn * std::numbers::pi / 180;
      const BytePlane edge =
          BlurredCells(1000, 0.5, radians, at - 100 * std::cos(radians), at - 100 * std::sin(radians));
      PeakScan scan;
      scan.Start(edge, 5);
      scan.Advance(edge, edge.height());
      EXPECT_TRUE(scan.peaks().empty()) << turn << " degrees, " << at;
    }
}

/// Of all levels.
std::size_t PeaksOf(const Pyramid& pyramid) {
  std::size_t count = 0;
  for (int level = 0; level < Pyramid::kLevels; ++level) {
    PeakScan scan;
    scan.Start(pyramid.level(level), 4);
    scan.Advance(pyramid.level(level), pyramid.level(level).height());
    count += scan.peaks().size();
  }
  return count;
}

TEST(FindCorners, LeavesOutMostOfTexturedGround) {
  Pyramid pyramid;
  std::vector<Corner> corners;
  for (const int most_off : {15, 20}) {
    SCOPED_TRACE(most_off);
    const Image image = Ground(most_off, 2);
    const int looked_at = FindCorners(image.view(), pyramid, corners);
    EXPECT_LT(looked_at, 0.4 * static_cast<double>(PeaksOf(pyramid)));
  }
}

TEST(FindCorners, KeepsABoardOnTexturedGround) {
  // Twice as much contrast as the ground, which has a lot to look at, and a board so dim beside another one.
  Image image = Ground(20, 3);
  const auto dim = DrawBoard(100, 100, 8, 70, 130, image), bright = DrawBoard(300, 200, 8, 20, 240, image);
  Pyramid pyramid;
  std::vector<Corner> corners;
  FindCorners(image.view(), pyramid, corners);
  EXPECT_EQ(CountFound(dim, corners), 25);
  EXPECT_EQ(CountFound(bright, corners), 25);
}

TEST(FindCorners, KeepsADimBoardWhereThereIsLittleElse) {
  Image image = Ground(1, 4);
  const auto places = DrawBoard(200, 150, 10, 94, 106, image);
  Pyramid pyramid;
  std::vector<Corner> corners;
  FindCorners(image.view(), pyramid, corners);
  EXPECT_GE(CountFound(places, corners), 24);
}

}  // namespace
}  // namespace chequer
