#include "simulate/coding.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace chequer {
namespace {

constexpr std::array kYuvFormats{PixelFormat::kYuyv,    PixelFormat::kUyvy,    PixelFormat::kNv12,
                                 PixelFormat::kYuv420p, PixelFormat::kYuv422p, PixelFormat::kYuv444p};

/// Blocks of 2 × 2 pixels of one colour each, so that shared chroma loses nothing.
Image Blocks(int width, int height) {
  Image image(PixelFormat::kBgr8, width, height);
  std::uint8_t* bytes = image.bytes().data();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        *bytes++ = static_cast<std::uint8_t>((60 + 37 * (x / 2) + 83 * (y / 2) + 101 * c) % 256);
  return image;
}

struct Yuv {
  int y, u, v;
};

/// Where each format keeps its samples, written out anew from their definitions.
Yuv SampleAt(const ImageView& image, int x, int y) {
  switch (image.format()) {
    case PixelFormat::kYuyv: {
      const std::uint8_t* pair = image.row(y) + 4 * (x / 2);
      return {pair[x % 2 == 0 ? 0 : 2], pair[1], pair[3]};
    }
    case PixelFormat::kUyvy: {
      const std::uint8_t* pair = image.row(y) + 4 * (x / 2);
      return {pair[x % 2 == 0 ? 1 : 3], pair[0], pair[2]};
    }
    case PixelFormat::kNv12: {
      const std::uint8_t* uv = image.row(y / 2, 1) + 2 * (x / 2);
      return {image.row(y)[x], uv[0], uv[1]};
    }
    case PixelFormat::kYuv420p: return {image.row(y)[x], image.row(y / 2, 1)[x / 2], image.row(y / 2, 2)[x / 2]};
    case PixelFormat::kYuv422p: return {image.row(y)[x], image.row(y, 1)[x / 2], image.row(y, 2)[x / 2]};
    default: return {image.row(y)[x], image.row(y, 1)[x], image.row(y, 2)[x]};
  }
}

std::array<double, 3> ToBgr(Yuv s, YuvRange range) {
  double y = s.y, u = s.u - 128, v = s.v - 128;
  if (range == YuvRange::kLimited) {
    y = (y - 16) * 255 / 219;
    u = u * 255 / 224;
    v = v * 255 / 224;
  }
  return {y + 1.772 * u, y - 0.344136 * u - 0.714136 * v, y + 1.402 * v};
}

TEST(ConvertFromBgr, EveryYuvFormatDecodesToTheSameColours) {
  const Image bgr = Blocks(10, 8);
  for (const PixelFormat format : kYuvFormats)
    for (const YuvRange range : {YuvRange::kFull, YuvRange::kLimited}) {
      const Image yuv = ConvertFromBgr(bgr.view(), format, range);
      EXPECT_EQ(yuv.view().yuv_range(), range);
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 10; ++x) {
          const auto back = ToBgr(SampleAt(yuv.view(), x, y), range);
          for (int c = 0; c < 3; ++c)
            // Half a level of Y, and of chroma times 1.772, of the limited range 1.16 times as much.
            EXPECT_NEAR(back[static_cast<std::size_t>(c)], bgr.view().row(y)[3 * x + c], 2.0)
                << PixelFormatName(format) << " at " << x << ", " << y << " channel " << c;
        }
    }
}

TEST(ConvertFromBgr, LimitedRangeRunsFrom16To235) {
  Image bgr(PixelFormat::kBgr8, 2, 2);
  EXPECT_EQ(ConvertFromBgr(bgr.view(), PixelFormat::kNv12, YuvRange::kLimited).bytes()[0], 16);
  for (std::uint8_t& value : bgr.bytes()) value = 255;
  EXPECT_EQ(ConvertFromBgr(bgr.view(), PixelFormat::kNv12, YuvRange::kLimited).bytes()[0], 235);
  EXPECT_EQ(ConvertFromBgr(bgr.view(), PixelFormat::kNv12, YuvRange::kFull).bytes()[0], 255);
}

TEST(ConvertFromBgr, OddSizesShareWhatIsThere) {
  const Image bgr = Blocks(5, 3);
  const Image yuv = ConvertFromBgr(bgr.view(), PixelFormat::kYuv420p);
  const auto back = ToBgr(SampleAt(yuv.view(), 4, 2), YuvRange::kFull);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(back[static_cast<std::size_t>(c)], bgr.view().row(2)[12 + c], 2.0);
}

TEST(ConvertFromBgr, RgbSwapsChannels) {
  const Image bgr = Blocks(4, 2);
  const Image rgb = ConvertFromBgr(bgr.view(), PixelFormat::kRgb8);
  for (int x = 0; x < 4; ++x)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(rgb.view().row(1)[3 * x + c], bgr.view().row(1)[3 * x + 2 - c]);
}

}  // namespace
}  // namespace chequer
