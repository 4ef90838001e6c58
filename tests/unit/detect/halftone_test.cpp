// Pictures in newspapers: screens of dots as regular as chessboards, which are none. How much work they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "chequer/detector.h"
#include "simulate/random.h"

namespace chequer {
namespace {

constexpr int kHalftoneSide = 640;

/// A picture's greys as dots of ink, in rows `pitch` px apart at 45°.
Image Halftone(double pitch_px, std::uint64_t seed) {
  constexpr int kParts = 3;  // of a pixel, along each axis
  Image image(PixelFormat::kMono8, kHalftoneSide, kHalftoneSide);
  Random random(seed);
  const double turn = 2 * M_PI / pitch_px * std::sqrt(0.5);
  for (int y = 0; y < kHalftoneSide; ++y)
    for (int x = 0; x < kHalftoneSide; ++x) {
      const double grey = 0.5 + 0.35 * std::sin(x / 110.0) * std::cos(y / 80.0);
      int paper = 0;
      for (int part = 0; part < kParts * kParts; ++part) {
        const double at_x = x + (part % kParts) / double{kParts}, at_y = y + (part / kParts) / double{kParts};
        paper += 0.5 + 0.25 * (std::cos(turn * (at_x + at_y)) + std::cos(turn * (at_x - at_y))) < grey;
      }
      const double light = 0.08 + 0.7 * paper / (kParts * kParts);
      const double code = 255 * std::pow(light, 1 / 2.2) + 1.5 * double{random.Normal()};
      image.bytes()[static_cast<std::size_t>(y * kHalftoneSide + x)] =
          static_cast<std::uint8_t>(std::clamp(code, 0.0, 255.0));
    }
  return image;
}

/// Noise, the mean of neighbours taken so many times.
Image CloudyTexture(int smooth_px, std::uint64_t seed) {
  Image image(PixelFormat::kMono8, kHalftoneSide, kHalftoneSide);
  Random random(seed);
  std::vector<double> values(kHalftoneSide * kHalftoneSide);
  for (double& value : values) value = random.Normal();
  const auto at = [&](int x, int y) -> double& {
    return values[static_cast<std::size_t>((y + kHalftoneSide) % kHalftoneSide * kHalftoneSide +
                                           (x + kHalftoneSide) % kHalftoneSide)];
  };
  for (int pass = 0; pass < smooth_px; ++pass)
    for (int y = 0; y < kHalftoneSide; ++y)
      for (int x = 0; x < kHalftoneSide; ++x)
        at(x, y) = (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 2;
  for (int i = 0; i < kHalftoneSide * kHalftoneSide; ++i)
    image.bytes()[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::clamp(120 + 35 * values[static_cast<std::size_t>(i)], 0.0, 255.0));
  return image;
}

std::uint64_t WorkOnNothing(const Image& image, std::uint64_t budget = 0) {
  DetectorOptions options;
  options.budget = budget;
  Detector detector(options);
  EXPECT_TRUE(detector.Detect(image.view()).empty());
  return detector.stats().work;
}

/// Of textures from fine to coarse.
std::uint64_t WorkOnCloudyTexture() {
  std::vector<std::uint64_t> work;
  for (const int smooth_px : {1, 2, 3, 5, 8}) work.push_back(WorkOnNothing(CloudyTexture(smooth_px, 7)));
  std::nth_element(work.begin(), work.begin() + 2, work.end());
  return work[2];
}

constexpr double kPitchesPx[] = {3, 3.5, 4, 4.5, 5, 6, 8};

TEST(Halftones, CostAtMostFourTimesATexture) {
  const std::uint64_t most = 4 * WorkOnCloudyTexture();
  for (const double pitch_px : kPitchesPx)
    EXPECT_LE(WorkOnNothing(Halftone(pitch_px, 3)), most) << "dots " << pitch_px << " px apart";
}

TEST(Halftones, CostNoMoreThanTheBudget) {
  constexpr std::uint64_t kBudget = 30000;
  for (const double pitch_px : kPitchesPx) {
    EXPECT_LE(WorkOnNothing(Halftone(pitch_px, 3), kBudget), kBudget) << "dots " << pitch_px << " px apart";
  }
}

}  // namespace
}  // namespace chequer
