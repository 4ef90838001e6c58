#include "detect/light.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace chequer {
namespace {

const std::array<float, 256> kTable = ToneCurve::Srgb().LinearTable();

test::KnownFrame Board(PixelFormat format) {
  test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 77, 14, 5);
  frame.options.format = format;
  return frame;
}

TEST(FindInterpolatedMosaic, FindsThePhaseOfADemosaicedImage) {
  test::KnownFrame frame = Board(PixelFormat::kBgr8);
  frame.options.sensor.bayer = PixelFormat::kBayerGb8;
  const Image image = frame.Draw();
  const auto mosaic = FindInterpolatedMosaic(image.view(), kTable, 290, 210, 350, 270);
  ASSERT_TRUE(mosaic.has_value());
  EXPECT_EQ(mosaic->red_x, 0);
  EXPECT_EQ(mosaic->red_y, 1);
}

TEST(FindInterpolatedMosaic, FullColourHasNone) {
  test::KnownFrame frame = Board(PixelFormat::kBgr8);
  frame.options.sensor.kind = SensorKind::kPerfect;
  const Image image = frame.Draw();
  EXPECT_FALSE(FindInterpolatedMosaic(image.view(), kTable, 290, 210, 350, 270).has_value());
}

TEST(LightReader, ReadsTheSameColourFromEveryFormat) {
  for (const PixelFormat format :
       {PixelFormat::kBgr8, PixelFormat::kRgb8, PixelFormat::kYuv444p, PixelFormat::kYuyv, PixelFormat::kUyvy,
        PixelFormat::kNv12, PixelFormat::kYuv420p, PixelFormat::kYuv422p, PixelFormat::kBayerRg8,
        PixelFormat::kBayerGb8, PixelFormat::kBayerGr8, PixelFormat::kBayerBg8}) {
    const Image reference = Board(PixelFormat::kBgr8).Draw(), image = Board(format).Draw();
    const LightReader expected(reference.view(), kTable), reader(image.view(), kTable);
    // Around the corner of the frame there is plain grey.
    const Eigen::Vector3f a = expected.Rgb(20, 20, 3), b = reader.Rgb(20, 20, 3);
    EXPECT_LT((a - b).norm(), 0.02f) << PixelFormatName(format) << ": " << a.transpose() << " and " << b.transpose();
  }
}

}  // namespace
}  // namespace chequer
