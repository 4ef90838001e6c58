#include "detect/common/light.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace chequer {
namespace {

const std::array<float, 256> kTable = ToneCurve::Srgb().LinearTable();

test::KnownFrame FrameOf(PixelFormat format) {
  test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 77, 14, 5);
  frame.options.format = format;
  return frame;
}

TEST(FindInterpolatedMosaic, FindsThePhaseOfADemosaicedImage) {
  test::KnownFrame frame = FrameOf(PixelFormat::kBgr8);
  frame.options.sensor.bayer = PixelFormat::kBayerGb8;
  const Image image = frame.Draw();
  const auto mosaic = FindInterpolatedMosaic(image.view(), kTable, 290, 210, 350, 270);
  ASSERT_TRUE(mosaic.has_value());
  EXPECT_EQ(mosaic->red_x, 0);
  EXPECT_EQ(mosaic->red_y, 1);
}

TEST(FindInterpolatedMosaic, FullColourHasNone) {
  test::KnownFrame frame = FrameOf(PixelFormat::kBgr8);
  frame.options.sensor.kind = SensorKind::kPerfect;
  const Image image = frame.Draw();
  EXPECT_FALSE(FindInterpolatedMosaic(image.view(), kTable, 290, 210, 350, 270).has_value());
}

TEST(LightReader, ReadsTheSameColourFromEveryFormat) {
  for (const PixelFormat format :
       {PixelFormat::kBgr8, PixelFormat::kRgb8, PixelFormat::kYuv444p, PixelFormat::kYuyv, PixelFormat::kUyvy,
        PixelFormat::kNv12, PixelFormat::kYuv420p, PixelFormat::kYuv422p, PixelFormat::kBayerRg8,
        PixelFormat::kBayerGb8, PixelFormat::kBayerGr8, PixelFormat::kBayerBg8}) {
    const Image reference = FrameOf(PixelFormat::kBgr8).Draw(), image = FrameOf(format).Draw();
    const LightReader expected(reference.view(), kTable), reader(image.view(), kTable);
    // Around the corner of the frame there is plain grey.
    const Eigen::Vector3f a = expected.Rgb(20, 20, 3), b = reader.Rgb(20, 20, 3);
    EXPECT_LT((a - b).norm(), 0.02f) << PixelFormatName(format) << ": " << a.transpose() << " and " << b.transpose();
  }
}

TEST(LightReader, SamplesTheSameLightFromLumaOfAnyRange) {
  for (const PixelFormat format : {PixelFormat::kYuyv, PixelFormat::kUyvy, PixelFormat::kNv12}) {
    test::KnownFrame frame = FrameOf(format);
    frame.options.sensor.full_well_electrons = 1e6;
    const Image full = frame.Draw();
    frame.options.yuv_range = YuvRange::kLimited;
    const Image limited = frame.Draw();
    const LightReader expected(full.view(), kTable), reader(limited.view(), kTable);
    // Dark, light and the steps between them.
    for (int x = 280; x < 360; ++x) {
      const LightReader::Run run = reader.AllRows().From(x, 240), same = expected.AllRows().From(x, 240);
      EXPECT_NEAR(run.table[*run.first], same.table[*same.first], 0.01) << PixelFormatName(format) << " at " << x;
    }
  }
}

TEST(LightReader, CodesAreThoseOfTheirLight) {
  for (const YuvRange range : {YuvRange::kFull, YuvRange::kLimited}) {
    const Image image(PixelFormat::kNv12, 16, 16, ToneCurve::Srgb(), range);
    const LightReader reader(image.view(), kTable);
    const Eigen::Vector3f light(0.6f, 0.3f, 0.1f);
    EXPECT_LT((reader.LightOf(reader.CodesOf(light)) - light).norm(), 1e-3f);
  }
}

TEST(LightReader, ReadsRoughlyWhatItReadsExactly) {
  for (const PixelFormat format :
       {PixelFormat::kMono8, PixelFormat::kBgr8, PixelFormat::kRgb8, PixelFormat::kYuv444p, PixelFormat::kYuyv,
        PixelFormat::kUyvy, PixelFormat::kNv12, PixelFormat::kYuv420p, PixelFormat::kYuv422p, PixelFormat::kBayerRg8,
        PixelFormat::kBayerGb8, PixelFormat::kBayerGr8, PixelFormat::kBayerBg8}) {
    test::KnownFrame frame = FrameOf(format);
    const SceneMarker& marker = frame.scene.markers[0];
    const Image image = frame.Draw();
    const LightReader reader(image.view(), kTable);
    // The middles of a board's cells, in all phases of a mosaic, and the image's corners, also from outside.
    std::vector<Eigen::Vector2d> places{{0, 0}, {-3, -2}, {639, 479}, {645.2, 480.7}};
    for (int row = 0; row < marker.board.rows; ++row)
      for (int col = 0; col < marker.board.cols; ++col)
        places.push_back(
            frame.options.camera.Project(marker.camera_from_marker * marker.PointAt(col + 0.5, row + 0.5)));
    for (const Eigen::Vector2d& at : places)
      for (const float half_px : {0.3f, 1.2f, 2.0f, 2.5f}) {
        const float x = static_cast<float>(at.x()), y = static_cast<float>(at.y());
        const Eigen::Vector3f a = reader.Rgb(x, y, half_px), b = reader.RoughRgb(x, y, half_px);
        EXPECT_LT((a - b).norm(), 0.03f) << PixelFormatName(format) << " at " << at.transpose() << ", " << half_px
                                         << " px: " << a.transpose() << " and " << b.transpose();
      }
  }
}

}  // namespace
}  // namespace chequer
