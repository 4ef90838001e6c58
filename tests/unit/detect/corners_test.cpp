#include "detect/corners.h"

#include <gtest/gtest.h>

#include <algorithm>
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
