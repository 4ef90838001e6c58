#include "core/convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

namespace chequer {
namespace {

using ::testing::ElementsAre;

std::vector<PixelFormat> AllFormats() {
  std::vector<PixelFormat> formats;
  for (int i = 0; i <= static_cast<int>(PixelFormat::kYuv444p); ++i) formats.push_back(static_cast<PixelFormat>(i));
  return formats;
}

/// Colours that change slowly, so that sharing chroma or demosaicing changes them little; no grey.
Image SmoothBgr(int width, int height) {
  Image image(PixelFormat::kBgr8, width, height);
  std::uint8_t* to = image.bytes().data();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      *to++ = static_cast<std::uint8_t>(60 + 2 * x);
      *to++ = static_cast<std::uint8_t>(120 + y);
      *to++ = static_cast<std::uint8_t>(200 - 2 * y - x);
    }
  return image;
}

int LargestDifference(const Image& a, const Image& b) {
  if (a.bytes().size() != b.bytes().size()) return 256;
  int largest = 0;
  for (std::size_t i = 0; i < a.bytes().size(); ++i) largest = std::max(largest, std::abs(a.bytes()[i] - b.bytes()[i]));
  return largest;
}

Image Make(PixelFormat format, int width, int height, std::initializer_list<std::uint8_t> bytes,
           YuvRange range = YuvRange::kFull) {
  Image image(format, width, height, ToneCurve::Srgb(), range);
  std::copy(bytes.begin(), bytes.end(), image.bytes().begin());
  return image;
}

TEST(ConvertImage, EveryColourFormatComesBackToNearlyTheSameColours) {
  const Image bgr = SmoothBgr(32, 20);
  for (const PixelFormat format : AllFormats())
    for (const YuvRange range : {YuvRange::kFull, YuvRange::kLimited}) {
      if (format == PixelFormat::kMono8) continue;
      const Image there = ConvertImage(bgr.view(), format, range);
      EXPECT_EQ(there.format(), format);
      const Image back = ToBgr(there.view());
      EXPECT_EQ(back.format(), PixelFormat::kBgr8);
      // 4:2:0 averages over two rows and two columns, which differ by up to 3 in red.
      EXPECT_LE(LargestDifference(back, bgr), 5) << PixelFormatName(format);
    }
}

TEST(ConvertImage, KeepsToneCurveAndStatesTheRange) {
  const Image linear(PixelFormat::kBgr8, 4, 4, ToneCurve::Linear());
  for (const PixelFormat format : AllFormats())
    EXPECT_EQ(ConvertImage(linear.view(), format).view().tone_curve(), ToneCurve::Linear());
  EXPECT_EQ(ConvertImage(linear.view(), PixelFormat::kNv12, YuvRange::kLimited).view().yuv_range(), YuvRange::kLimited);
}

TEST(ConvertImage, KnowsTheColoursOfBt601) {
  const Image red = Make(PixelFormat::kRgb8, 2, 1, {255, 0, 0, 255, 0, 0});
  EXPECT_THAT(ConvertImage(red.view(), PixelFormat::kYuyv).bytes(), ElementsAre(76, 85, 76, 255));
  EXPECT_THAT(ConvertImage(red.view(), PixelFormat::kYuyv, YuvRange::kLimited).bytes(), ElementsAre(81, 90, 81, 240));
  const Image white = Make(PixelFormat::kMono8, 2, 1, {255, 0});
  EXPECT_THAT(ConvertImage(white.view(), PixelFormat::kYuyv, YuvRange::kLimited).bytes(),
              ElementsAre(235, 128, 16, 128));
}

TEST(ConvertImage, LaysOutEachYuvFormat) {
  // Two pixels a row share chroma; both rows have the same colours, so that 4:2:0 has them too.
  const Image yuyv = Make(PixelFormat::kYuyv, 4, 2, {1, 100, 2, 150, 3, 110, 4, 160, 1, 100, 2, 150, 3, 110, 4, 160});
  const auto as = [&](PixelFormat format) {
    const Image image = ConvertImage(yuyv.view(), format);
    return std::vector<int>(image.bytes().begin(), image.bytes().end());
  };
  EXPECT_THAT(as(PixelFormat::kUyvy), ElementsAre(100, 1, 150, 2, 110, 3, 160, 4, 100, 1, 150, 2, 110, 3, 160, 4));
  EXPECT_THAT(as(PixelFormat::kNv12), ElementsAre(1, 2, 3, 4, 1, 2, 3, 4, 100, 150, 110, 160));
  EXPECT_THAT(as(PixelFormat::kYuv420p), ElementsAre(1, 2, 3, 4, 1, 2, 3, 4, 100, 110, 150, 160));
  EXPECT_THAT(as(PixelFormat::kYuv422p), ElementsAre(1, 2, 3, 4, 1, 2, 3, 4, 100, 110, 100, 110, 150, 160, 150, 160));
  EXPECT_THAT(as(PixelFormat::kYuv444p), ElementsAre(1, 2, 3, 4, 1, 2, 3, 4, 100, 100, 110, 110, 100, 100, 110, 110,
                                                     150, 150, 160, 160, 150, 150, 160, 160));
  EXPECT_THAT(as(PixelFormat::kMono8), ElementsAre(1, 2, 3, 4, 1, 2, 3, 4));
}

TEST(ConvertImage, AveragesChromaOverThePixelsThatShareIt) {
  const Image full = Make(PixelFormat::kYuv444p, 2, 2, {9, 9, 9, 9, 10, 20, 30, 40, 50, 60, 70, 80});
  EXPECT_THAT(ConvertImage(full.view(), PixelFormat::kNv12).bytes(), ElementsAre(9, 9, 9, 9, 25, 65));
  EXPECT_THAT(ConvertImage(full.view(), PixelFormat::kYuv422p).bytes(), ElementsAre(9, 9, 9, 9, 15, 35, 55, 75));
}

TEST(ConvertImage, RepackingYuvLosesNothing) {
  Image yuyv(PixelFormat::kYuyv, 16, 16);
  for (std::size_t i = 0; i < yuyv.bytes().size(); ++i) yuyv.bytes()[i] = static_cast<std::uint8_t>(i * 37);
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kYuv422p, PixelFormat::kYuv444p}) {
    const Image there = ConvertImage(yuyv.view(), format);
    EXPECT_EQ(LargestDifference(ConvertImage(there.view(), PixelFormat::kYuyv), yuyv), 0);
  }
}

TEST(ConvertImage, ChangesTheRangeOfYuv) {
  const Image limited = Make(PixelFormat::kYuyv, 2, 1, {16, 240, 235, 128}, YuvRange::kLimited);
  EXPECT_THAT(ConvertImage(limited.view(), PixelFormat::kYuyv).bytes(), ElementsAre(0, 255, 255, 128));
}

TEST(ConvertImage, MosaicsInAllFourPhases) {
  const Image bgr = Make(PixelFormat::kBgr8, 2, 2, {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3});
  EXPECT_THAT(ConvertImage(bgr.view(), PixelFormat::kBayerRg8).bytes(), ElementsAre(3, 2, 2, 1));
  EXPECT_THAT(ConvertImage(bgr.view(), PixelFormat::kBayerGr8).bytes(), ElementsAre(2, 3, 1, 2));
  EXPECT_THAT(ConvertImage(bgr.view(), PixelFormat::kBayerGb8).bytes(), ElementsAre(2, 1, 3, 2));
  EXPECT_THAT(ConvertImage(bgr.view(), PixelFormat::kBayerBg8).bytes(), ElementsAre(1, 2, 2, 3));
}

TEST(ToBgr, DemosaicsFromTheNeighboursOfAColour) {
  const Image raw = Make(PixelFormat::kBayerRg8, 3, 3, {10, 1, 20, 2, 50, 3, 30, 4, 40});
  const Image bgr = ToBgr(raw.view());
  const auto pixel = [&](int x, int y) {
    const std::uint8_t* p = bgr.view().row(y) + 3 * x;
    return std::vector<int>{p[0], p[1], p[2]};
  };
  EXPECT_THAT(pixel(1, 1), ElementsAre(50, 3, 25));  // (1 + 2 + 3 + 4) / 4 rounded; (10 + 20 + 30 + 40) / 4
  EXPECT_THAT(pixel(1, 0), ElementsAre(50, 1, 15));
  EXPECT_THAT(pixel(0, 0), ElementsAre(50, 2, 10));
}

TEST(ToBgr, OddAndTinySizesOfEveryFormatThatHasThem) {
  for (const PixelFormat format : AllFormats())
    for (const int width : {1, 2, 3})
      for (const int height : {1, 2, 3}) {
        if (!SizeIsValid(format, width, height)) continue;
        const Image image(format, width, height);
        EXPECT_EQ(ToBgr(image.view()).width(), width);
        for (const PixelFormat other : AllFormats())
          if (SizeIsValid(other, width, height)) {
            EXPECT_EQ(ConvertImage(image.view(), other).height(), height);
          }
      }
}

TEST(ConvertImage, ReadsRowsThatAreFarApart) {
  const std::vector<std::uint8_t> bytes{1, 2, 99, 3, 4, 99};
  const Plane plane{bytes.data(), 3};
  const ImageView view(PixelFormat::kMono8, 2, 2, {&plane, 1});
  EXPECT_THAT(ConvertImage(view, PixelFormat::kMono8).bytes(), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(ToBgr(view).bytes(), ElementsAre(1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4));
}

TEST(ConvertImageDeathTest, ASizeThatTheFormatCannotHaveIsABug) {
  const Image odd(PixelFormat::kBgr8, 3, 3);
  EXPECT_DEATH(ConvertImage(odd.view(), PixelFormat::kYuyv), "not valid for the format wanted");
}

}  // namespace
}  // namespace chequer
