#include "core/picture_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace chequer {
namespace {

/// Squares of 40 px whose edges are linear ramps along x and along y of those widths, with noise.
Image Squares(PixelFormat format, double width_x, double width_y, int dark = 40, int bright = 200) {
  Image image(format, 640, 480);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 2);
  const int channels = format == PixelFormat::kBgr8 ? 3 : 1;
  const auto wave = [](double at, double width) {
    const double in = std::fmod(at, 80.0) - 40;  // edges in the middle and at the ends
    return std::clamp((20 - std::abs(std::abs(in) - 20) - 0) / width, 0.0, 0.5) * (in < 0 ? -1 : 1);
  };
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      const double light = 0.5 + 2 * wave(x, width_x) * wave(y, width_y);
      const double level = dark + (bright - dark) * light + noise(random);
      for (int c = 0; c < channels; ++c)
        image.bytes()[static_cast<std::size_t>((y * 640 + x) * channels + c)] =
            static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0));
    }
  return image;
}

PictureCheck Check(const ImageView& image) { return CheckPicture(image, 48); }

TEST(PictureCheck, KnowsBlackWhiteAndBlank) {
  Image image(PixelFormat::kBgr8, 64, 48);
  EXPECT_TRUE(Check(image.view()).IsBlack());
  std::fill(image.bytes().begin(), image.bytes().end(), std::uint8_t{120});
  const PictureCheck grey = Check(image.view());
  EXPECT_FALSE(grey.IsBlack());
  EXPECT_TRUE(grey.IsBlank());
  EXPECT_FALSE(grey.Blur()) << "nothing to tell it from";
  std::fill(image.bytes().begin(), image.bytes().end(), std::uint8_t{255});
  EXPECT_TRUE(Check(image.view()).IsWhite());
}

TEST(PictureCheck, ACoveredSensorsNoiseIsBlack) {
  Image image(PixelFormat::kMono8, 320, 240);
  std::mt19937 random(2);
  for (std::uint8_t& byte : image.bytes()) byte = static_cast<std::uint8_t>(random() % 8);
  EXPECT_TRUE(Check(image.view()).IsBlack());
}

TEST(PictureCheck, SharpPicturesAreNotBlurred) {
  for (const PixelFormat format : {PixelFormat::kMono8, PixelFormat::kBgr8})
    for (const double width : {1.0, 2.0, 3.0}) {
      const PictureCheck check = Check(Squares(format, width, width).view());
      EXPECT_TRUE(check.edge_along_rows_px && check.edge_along_columns_px);
      EXPECT_FALSE(check.Blur()) << width;
      EXPECT_FALSE(check.IsBlank() || check.IsBlack() || check.IsWhite());
    }
}

TEST(PictureCheck, MeasuresBlur) {
  const auto blur = Check(Squares(PixelFormat::kMono8, 14, 14).view()).Blur();
  ASSERT_TRUE(blur);
  EXPECT_NEAR(*blur, 14, 5);
}

TEST(PictureCheck, MeasuresBothWays) {
  const PictureCheck check = Check(Squares(PixelFormat::kMono8, 14, 1).view());
  ASSERT_TRUE(check.edge_along_rows_px && check.edge_along_columns_px);
  EXPECT_GT(*check.edge_along_rows_px, 8);
  EXPECT_LT(*check.edge_along_columns_px, 4);
  EXPECT_FALSE(check.Blur()) << "it may be wood";
}

TEST(PictureCheck, TakesEveryFormatAndSize) {
  for (const PixelFormat format :
       {PixelFormat::kMono8, PixelFormat::kBgr8, PixelFormat::kBayerRg8, PixelFormat::kBayerGb8, PixelFormat::kBayerGr8,
        PixelFormat::kBayerBg8, PixelFormat::kYuyv, PixelFormat::kUyvy, PixelFormat::kNv12, PixelFormat::kYuv420p})
    for (const int side : {2, 4, 50}) {
      Image image(format, side, side);
      std::fill(image.bytes().begin(), image.bytes().end(), std::uint8_t{200});
      EXPECT_TRUE(Check(image.view()).IsBlank()) << PixelFormatName(format);
    }
  EXPECT_TRUE(Check(Image(PixelFormat::kMono8, 1, 1).view()).IsBlack());
  EXPECT_FALSE(Check(ImageView()).Blur());
}

}  // namespace
}  // namespace chequer
