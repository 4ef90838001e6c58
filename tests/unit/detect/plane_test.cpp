#include "detect/common/plane.h"

#include <gtest/gtest.h>

#include <random>

namespace chequer {
namespace {

/// Random bytes; odd widths leave a rest behind the vectors.
Image Noise(PixelFormat format, int width, int height) {
  Image image(format, width, height);
  std::mt19937 random(11);
  for (std::uint8_t& byte : image.bytes()) byte = static_cast<std::uint8_t>(random());
  return image;
}

TEST(DetectionPlane, ColourIsTheMeanOfRedAndGreen) {
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kRgb8}) {
    const Image image = Noise(format, 203, 5);
    DetectionPlane plane;
    BuildDetectionPlane(image.view(), plane);
    ASSERT_EQ(plane.plane.width(), 203);
    const int red = format == PixelFormat::kBgr8 ? 2 : 0;
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 203; ++x) {
        const std::uint8_t* p = image.view().row(y) + 3 * x;
        ASSERT_EQ(plane.plane.at(x, y), (p[1] + p[red] + 1) / 2) << x << ", " << y;
      }
  }
}

TEST(DetectionPlane, BayerLeavesBlueOut) {
  // In every phase the plane of a mosaic with only its blue samples lit is black, and that of the others is not.
  for (const auto& [format, red_x, red_y] : {std::tuple{PixelFormat::kBayerRg8, 0, 0},
                                             {PixelFormat::kBayerGr8, 1, 0},
                                             {PixelFormat::kBayerGb8, 0, 1},
                                             {PixelFormat::kBayerBg8, 1, 1}}) {
    Image image(format, 150, 9);
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 150; ++x)
        if ((x & 1) != red_x && (y & 1) != red_y) image.bytes()[static_cast<std::size_t>(150 * y + x)] = 255;
    DetectionPlane plane;
    BuildDetectionPlane(image.view(), plane);
    EXPECT_EQ(plane.offset_px, 0.5f);
    ASSERT_EQ(plane.plane.width(), 149);
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 149; ++x)
        ASSERT_EQ(plane.plane.at(x, y), 0) << PixelFormatName(format) << " " << x << ", " << y;
    for (std::uint8_t& byte : image.bytes()) byte = static_cast<std::uint8_t>(200 - byte % 255);
    BuildDetectionPlane(image.view(), plane);
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 149; ++x)
        ASSERT_EQ(plane.plane.at(x, y), 200) << PixelFormatName(format) << " " << x << ", " << y;
  }
}

TEST(DetectionPlane, BayerIsTheMeanOfRedAndGreenWhateverItsWidth) {
  for (int width = 2; width < 150; ++width) {
    const Image image = Noise(PixelFormat::kBayerRg8, width, 4);
    const ImageView view = image.view();
    DetectionPlane plane;
    BuildDetectionPlane(view, plane);
    ASSERT_EQ(plane.plane.width(), width - 1);
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < width - 1; ++x) {
        const std::uint8_t *red_row = view.row(y + (y & 1)), *blue_row = view.row(y + 1 - (y & 1));
        const int red_and_green = (red_row[x] + red_row[x + 1] + 1) / 2, green = blue_row[x + (x & 1)];
        ASSERT_EQ(plane.plane.at(x, y), (red_and_green + green + 1) / 2) << width << ": " << x << ", " << y;
      }
  }
}

TEST(DetectionPlane, YuvTakesLuma) {
  for (const auto& [format, offset, step] : {std::tuple{PixelFormat::kYuyv, 0, 2},
                                             {PixelFormat::kUyvy, 1, 2},
                                             {PixelFormat::kNv12, 0, 1},
                                             {PixelFormat::kYuv420p, 0, 1}}) {
    const Image image = Noise(format, 202, 4);
    DetectionPlane plane;
    BuildDetectionPlane(image.view(), plane);
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 202; ++x)
        ASSERT_EQ(plane.plane.at(x, y), image.view().row(y)[step * x + offset])
            << PixelFormatName(format) << " " << x << ", " << y;
  }
}

TEST(HalveRows, EachPixelIsTheMeanOfFour) {
  const Image image = Noise(PixelFormat::kMono8, 131, 7);
  DetectionPlane full;
  BuildDetectionPlane(image.view(), full);
  BytePlane half;
  half.Resize(full.plane.width() / 2, full.plane.height() / 2);
  HalveRows(full.plane, 0, half.height(), half);
  ASSERT_EQ(half.width(), 65);
  ASSERT_EQ(half.height(), 3);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 65; ++x) {
      const int sum = full.plane.at(2 * x, 2 * y) + full.plane.at(2 * x + 1, 2 * y) + full.plane.at(2 * x, 2 * y + 1) +
                      full.plane.at(2 * x + 1, 2 * y + 1);
      ASSERT_NEAR(half.at(x, y), sum / 4.0, 1.01) << x << ", " << y;  // rounded up twice
    }
}

}  // namespace
}  // namespace chequer
