#include "daemon/preview.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "capture/jpeg.h"
#include "core/convert.h"
#include "daemon/marker_detail.h"
#include "support/scenes.h"

namespace chequer {
namespace {

constexpr std::array kFormats{PixelFormat::kMono8,    PixelFormat::kBgr8,     PixelFormat::kRgb8,
                              PixelFormat::kBayerRg8, PixelFormat::kBayerGb8, PixelFormat::kBayerGr8,
                              PixelFormat::kBayerBg8, PixelFormat::kYuyv,     PixelFormat::kUyvy,
                              PixelFormat::kNv12,     PixelFormat::kYuv420p,  PixelFormat::kYuv422p,
                              PixelFormat::kYuv444p};

/// Four fields of colour: red, green / blue, grey.
Image Fields(int width, int height) {
  Image image(PixelFormat::kBgr8, width, height);
  std::uint8_t* out = image.bytes().data();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool right = x >= width / 2, low = y >= height / 2;
      const std::uint8_t bgr[] = {static_cast<std::uint8_t>(low && !right  ? 220
                                                            : right && low ? 128
                                                                           : 20),
                                  static_cast<std::uint8_t>(right ? (low ? 128 : 220) : 20),
                                  static_cast<std::uint8_t>(!right && !low ? 220
                                                            : right && low ? 128
                                                                           : 20)};
      out = std::copy(std::begin(bgr), std::end(bgr), out);
    }
  return image;
}

std::array<int, 3> BgrAt(const Image& image, double x, double y) {
  const std::uint8_t* pixel =
      image.view().row(static_cast<int>(y * image.height())) + 3 * static_cast<int>(x * image.width());
  return {pixel[0], pixel[1], pixel[2]};
}

TEST(Preview, ShowsTheColoursOfEveryFormat) {
  const Image fields = Fields(128, 96);
  for (const PixelFormat format : kFormats) {
    const Image frame = ConvertImage(fields.view(), format);
    const Preview preview = PreviewMaker().Make(frame.view(), {}, 64);
    EXPECT_EQ(preview.region, (PixelRegion{0, 0, 128, 96}));
    ASSERT_EQ(preview.width, 64);
    ASSERT_EQ(preview.height, 48);
    const Image shown = ToBgr(ImageFromJpeg(preview.jpeg, JpegColour::kBgr).view());
    const Image truth = ToBgr(frame.view());
    for (const double x : {0.25, 0.75})
      for (const double y : {0.25, 0.75})
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(BgrAt(shown, x, y)[c], BgrAt(truth, x, y)[c], 8)
              << PixelFormatName(format) << " at " << x << ", " << y << " channel " << c;
  }
}

TEST(Preview, ShowsLimitedRangeAndLinearValuesAsAScreenNeedsThem) {
  const Image limited = ConvertImage(Fields(64, 64).view(), PixelFormat::kYuyv, YuvRange::kLimited);
  const Image shown = ToBgr(ImageFromJpeg(PreviewMaker().Make(limited.view(), {}, 64).jpeg, JpegColour::kBgr).view());
  EXPECT_NEAR(BgrAt(shown, 0.25, 0.25)[2], 220, 12);
  Image linear(PixelFormat::kMono8, 64, 64, ToneCurve::Linear());
  std::fill(linear.bytes().begin(), linear.bytes().end(), std::uint8_t{55});
  const Image bright = ImageFromJpeg(PreviewMaker().Make(linear.view(), {}, 64).jpeg, JpegColour::kBgr);
  EXPECT_NEAR(bright.bytes()[100], 128, 4) << "a fifth of white's light is mid-grey on a screen";
}

TEST(Preview, ShowsARegionOfTheFrame) {
  const Image frame = ConvertImage(Fields(128, 96).view(), PixelFormat::kYuv420p);
  const Preview preview = PreviewMaker().Make(frame.view(), {71, 5, 40, 30}, 640);
  EXPECT_EQ(preview.region, (PixelRegion{70, 4, 42, 32})) << "whole chroma samples";
  EXPECT_EQ(preview.width, 42) << "no more pixels than there are";
  const Image shown = ToBgr(ImageFromJpeg(preview.jpeg, JpegColour::kBgr).view());
  EXPECT_NEAR(BgrAt(shown, 0.5, 0.5)[1], 220, 10) << "the green field";
  EXPECT_TRUE(PreviewMaker().Make(frame.view(), {500, 500, 10, 10}, 640).jpeg.empty());
  EXPECT_FALSE(PreviewMaker().Make(frame.view(), {100, 80, 10000, 10000}, 640).jpeg.empty())
      << "what lies in the frame is shown";
}

TEST(MarkerDetail, ShowsTheCellsThatAMarkerHas) {
  const CameraModel camera = test::PlainCamera();
  const MarkerCode code(MarkerSize{6, 6}, Variant::kSecded);
  Scene scene;
  scene.markers.push_back(test::MarkerOf(code, 17, {RotationFromVector({M_PI, 0, 0.3}), {0.05, -0.1, 1.0}}));
  RenderOptions options;
  options.camera = camera;
  const std::string colours = CellColours({6, 6}, code.Encode(17));
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kYuv420p, PixelFormat::kBayerRg8}) {
    const Image frame = ConvertImage(Render(scene, options, 1).view(), format);
    DetectorOptions detector;
    detector.families = {MarkerFamily{code, 0.12, {}}};
    const auto found = Detector(detector).Detect(frame.view());
    ASSERT_EQ(found.size(), 1u);
    const DetailMessage detail = MarkerDetail(detector).Look(frame.view(), found[0]);
    ASSERT_TRUE(detail.found) << detail.message;
    EXPECT_EQ(detail.id, 17u);
    ASSERT_EQ(detail.cells.size(), 36u);
    std::string seen;
    for (int i = 0; i < 36; ++i) {
      const DetailCell& cell = detail.cells[static_cast<std::size_t>(i)];
      const bool saturated = cell.saturated.value_or(false);
      seen.push_back(IsDark(i / 6, i % 6) ? (saturated ? 'B' : 'K') : saturated ? 'Y' : 'W');
    }
    EXPECT_EQ(seen, colours) << PixelFormatName(format);
    EXPECT_LT((detail.center_px - found[0].center_px).norm(), 0.05);
    for (std::size_t i = 0; i < 25; ++i) EXPECT_LT((detail.corners[i] - found[0].corners[i]).norm(), 0.1F) << i;
    EXPECT_LT(detail.luminance_dark.mean + 20, detail.luminance_light.mean);
    EXPECT_LT(detail.saturation_plain.mean + 10, detail.saturation_saturated.mean);
  }
}

TEST(MarkerDetail, FindsAMarkerWithoutAnIdByItsPlace) {
  std::vector<MarkerPose> markers(3);
  markers[0].id = 4;
  markers[0].center_px = {100, 100};
  markers[1].center_px = {110, 100};
  markers[2].center_px = {300, 100};
  EXPECT_EQ(FindChoice({0, 4, {0, 0}}, markers), &markers[0]);
  EXPECT_EQ(FindChoice({1, 4, {0, 0}}, markers), nullptr) << "of another family";
  EXPECT_EQ(FindChoice({0, std::nullopt, {290, 100}}, markers), &markers[2]);
  EXPECT_EQ(FindChoice({0, std::nullopt, {200, 200}}, markers), nullptr);
}

}  // namespace
}  // namespace chequer
