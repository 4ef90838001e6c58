#include "simulate/render.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "simulate/layouts.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

MarkerCode Secded() { return MarkerCode(MarkerSize{}, Variant::kSecded); }

RenderOptions PinholeOptions(int width = 320, int height = 240) {
  RenderOptions options;
  options.camera = {.width = width, .height = height, .fx = 500, .fy = 500, .cx = width / 2.0, .cy = height / 2.0};
  return options;
}

SceneMarker Marker(const MarkerCode& code, std::uint64_t id, const RigidTransform& pose, double side_m = 0.24) {
  SceneMarker marker;
  marker.board = MakeBoard(code, id);
  marker.side_m = side_m;
  marker.camera_from_marker = pose;
  return marker;
}

Scene SceneOf(std::vector<SceneMarker> markers) {
  Scene scene;
  scene.markers = std::move(markers);
  return scene;
}

/// The ink nearest to the light in the middle of each cell, as it is seen.
std::string ReadCells(const SceneMarker& marker, const LinearImage& light, const CameraModel& camera) {
  std::string cells;
  for (int row = 0; row < marker.board.rows; ++row)
    for (int col = 0; col < marker.board.cols; ++col) {
      const Eigen::Vector2d p = camera.Project(marker.camera_from_marker * marker.PointAt(col + 0.5, row + 0.5));
      const float* pixel = light.Pixel(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
      const Eigen::Vector3f seen(pixel[0], pixel[1], pixel[2]);
      char best = '?';
      float least = std::numeric_limits<float>::infinity();
      for (const char colour : {'K', 'W', 'B', 'Y'}) {
        const float distance = (marker.inks.Of(colour) - seen).squaredNorm();
        if (distance < least) {
          least = distance;
          best = colour;
        }
      }
      cells += best;
    }
  return cells;
}

TEST(Render, CellsOfEverySizeShowTheCode) {
  for (const MarkerSize size :
       {MarkerSize{3, 3}, MarkerSize{4, 6}, MarkerSize{6, 6}, MarkerSize{7, 5}, MarkerSize{10, 10}}) {
    const MarkerCode code(size, Variant::kUnconstrained);
    const RenderOptions options = PinholeOptions();
    const Scene scene = SceneOf(
        {Marker(code, std::min<std::uint64_t>(code.max_id(), 0x1234567), FacingPose({0.02, -0.01, 1.2}, 0.8, 0.4))});
    const LinearImage light = RenderLight(scene, options);
    EXPECT_EQ(ReadCells(scene.markers[0], light, options.camera),
              CellColours(size, code.Encode(scene.markers[0].board.id)))
        << ToString(size);
  }
}

TEST(Render, DistortedAndFisheyeCamerasShowTheCodeToo) {
  RenderOptions options = PinholeOptions(640, 480);
  options.camera = PublicationCamera();
  Scene scene = SceneOf({Marker(Secded(), 99, FacingPose({-0.3, 0.15, 0.8}, 2.1, 0.3))});
  EXPECT_EQ(ReadCells(scene.markers[0], RenderLight(scene, options), options.camera), scene.markers[0].board.cells);
  options.camera.kind = CameraModel::Kind::kFisheye;
  options.camera.distortion = {-0.02, 0.003, -0.001, 0.0002, 0};
  EXPECT_EQ(ReadCells(scene.markers[0], RenderLight(scene, options), options.camera), scene.markers[0].board.cells);
}

TEST(Render, MirroredMarkersAreSeenTheOtherWayRound) {
  const RenderOptions options = PinholeOptions();
  Scene scene = SceneOf({Marker(Secded(), 1203, FacingPose({0, 0, 1}, 0))});
  scene.markers[0].mirrored = true;
  const LinearImage light = RenderLight(scene, options);
  SceneMarker upright = scene.markers[0];
  upright.mirrored = false;
  std::string reversed;
  for (std::size_t row = 0; row < 6; ++row) {
    const std::string cells = upright.board.cells.substr(6 * row, 6);
    reversed.append(cells.rbegin(), cells.rend());
  }
  EXPECT_EQ(ReadCells(upright, light, options.camera), reversed);
}

TEST(Render, ShadowsFallOnMarkersAndGroundBeforeTheLens) {
  RenderOptions options = PinholeOptions();
  Scene scene = SceneOf({Marker(Secded(), 7, FacingPose({0, 0, 1}, 0.3))});
  scene.background.colour.setConstant(0.4f);
  const LinearImage plain = RenderLight(scene, options);
  // Upright, through the middle of the marker.
  const double middle = options.camera.cx;
  options.shadow = {.takes = 0.6, .direction_rad = 0, .through_x = middle, .through_y = 0, .width_px = 0.01};
  const LinearImage shaded = RenderLight(scene, options);
  const int width = plain.width, height = plain.height, edge = static_cast<int>(middle);
  for (int y = 0; y < height; y += 3)
    for (int x = 0; x < width; x += 3) {
      if (std::abs(x - middle) < 5 * options.blur_sigma_px + 1) continue;
      EXPECT_NEAR(shaded.Pixel(x, y)[1], (x > middle ? 0.4f : 1.0f) * plain.Pixel(x, y)[1], 1e-5) << x << ", " << y;
    }
  // On plain ground: the lens blurs the edge.
  const float light = plain.Pixel(edge, 3)[1];
  double below = 0;
  for (int x = edge - 8; x <= edge + 8; ++x) below += 1 - double{shaded.Pixel(x, 3)[1]} / double{light};
  EXPECT_NEAR(below, 0.6 * (8.5 - (middle - edge)), 0.02) << "the edge lies where it was put";
  EXPECT_LT(shaded.Pixel(edge - 1, 3)[1], light - 1e-3) << "and is blurred";
}

TEST(Render, TouchingMarkersLeaveNoSeam) {
  // Two white boards edge to edge, turned so that the common edge crosses pixels at all phases, before black.
  const RenderOptions options = PinholeOptions();
  SceneMarker left = Marker(Secded(), 0, FacingPose({0, 0, 1}, 0.37), 0.12);
  left.board.cells.assign(36, 'W');
  SceneMarker right = left;
  right.camera_from_marker.translation = left.camera_from_marker * Eigen::Vector3d(0.12, 0, 0);
  Scene scene = SceneOf({left, right});
  scene.background.colour.setZero();
  const LinearImage light = RenderLight(scene, options);
  for (double row = 1; row < 5; row += 0.05) {
    const Eigen::Vector2d p = options.camera.Project(left.camera_from_marker * left.PointAt(6, row));
    const float* pixel = light.Pixel(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
    EXPECT_NEAR(pixel[0], left.inks.white.x(), 1e-4f) << "row " << row;
  }
}

TEST(Render, LaterMarkersLieOverEarlierOnes) {
  const RenderOptions options = PinholeOptions();
  const SceneMarker below = Marker(Secded(), 5, FacingPose({0, 0, 1}, 0));
  const SceneMarker above = Marker(Secded(), 1500, FacingPose({0.03, 0.02, 0.9}, 0.5));
  const LinearImage light = RenderLight(SceneOf({below, above}), options);
  EXPECT_EQ(ReadCells(above, light, options.camera), above.board.cells);
}

TEST(Render, OccludersHideTheirPartAndNoMore) {
  const RenderOptions options = PinholeOptions();
  Scene scene = SceneOf({Marker(Secded(), 321, FacingPose({0, 0, 1}, 0.2))});
  scene.markers[0].occluders.push_back({.from = {-0.1, 0.5}, .to = {1.1, 1.1}, .colour = scene.markers[0].inks.blue});
  const std::string cells = ReadCells(scene.markers[0], RenderLight(scene, options), options.camera);
  EXPECT_EQ(cells.substr(0, 18), scene.markers[0].board.cells.substr(0, 18));
  EXPECT_EQ(cells.substr(18), std::string(18, 'B'));
}

TEST(Render, TexturedOccludersHideToo) {
  RenderOptions options = PinholeOptions();
  Scene scene = SceneOf({Marker(Secded(), 321, FacingPose({0, 0, 1}, 0.2))});
  scene.markers[0].occluders.push_back({.patches = 7, .seed = 4});
  const LinearImage covered = RenderLight(scene, options);
  scene.markers[0].board = MakeBoard(Secded(), 1000);
  const LinearImage another = RenderLight(scene, options);
  for (std::size_t i = 0; i < covered.rgb.size(); ++i) ASSERT_NEAR(covered.rgb[i], another.rgb[i], 1e-4f);
}

TEST(Render, InkSpreadsByItsArea) {
  // All dark cells 0 and all light ones 1, on a white margin: what is missing of the light is the union of the grown
  // cells.
  RenderOptions options = PinholeOptions();
  Scene scene = SceneOf({Marker(Secded(), 700, FacingPose({0, 0, 1}, 0.3))});
  scene.background.colour.setOnes();
  SceneMarker& marker = scene.markers[0];
  marker.inks.black = marker.inks.blue = {0, 0, 0};
  marker.inks.white = marker.inks.yellow = {1, 1, 1};
  marker.margin_cells = 1;
  const double cell_px2 = 20 * 20;
  for (const double spread : {0.0, 0.1, 0.3}) {
    marker.ink_spread_cells = spread;
    const LinearImage light = RenderLight(scene, options);
    double dark = 0;
    for (std::size_t i = 0; i < light.rgb.size(); i += 3) dark += 1 - static_cast<double>(light.rgb[i]);
    const double grown = 18 * (1 + 2 * spread) * (1 + 2 * spread) - 25 * 4 * spread * spread;
    EXPECT_NEAR(dark / cell_px2, grown, 2e-3) << spread;
  }
}

TEST(Render, InkSpreadsOverTheBackgroundWithoutMargin) {
  RenderOptions options = PinholeOptions();
  Scene scene = SceneOf({Marker(Secded(), 700, FacingPose({0, 0, 1}, 0.3))});
  scene.background.colour.setOnes();
  SceneMarker& marker = scene.markers[0];
  marker.inks.black = marker.inks.blue = {0, 0, 0};
  marker.inks.white = marker.inks.yellow = {1, 1, 1};
  marker.ink_spread_cells = 0.2;
  const LinearImage light = RenderLight(scene, options);
  double dark = 0;
  for (std::size_t i = 0; i < light.rgb.size(); i += 3) dark += 1 - static_cast<double>(light.rgb[i]);
  EXPECT_NEAR(dark / 400, 18 * 1.4 * 1.4 - 25 * 0.16, 2e-3);
}

TEST(Render, GradientFallsAcrossTheMarker) {
  RenderOptions options = PinholeOptions();
  Scene scene = SceneOf({Marker(Secded(), 0, FacingPose({0, 0, 1}, 0))});
  SceneMarker& marker = scene.markers[0];
  marker.board.cells.assign(36, 'W');
  marker.gradient = 0.8;
  const LinearImage light = RenderLight(scene, options);
  // 120 px across 160 ± 60.
  const float white = marker.inks.white.x();
  EXPECT_NEAR(light.Pixel(103, 120)[0], white * (1 - 0.8f * 3 / 120), 0.01f);
  EXPECT_NEAR(light.Pixel(160, 120)[0], white * 0.6f, 0.01f);
  EXPECT_NEAR(light.Pixel(217, 120)[0], white * (1 - 0.8f * 117 / 120), 0.01f);
}

TEST(Render, MarkersOverTheFramesRimAreCutOff) {
  RenderOptions options = PinholeOptions();
  const SceneMarker marker = Marker(Secded(), 5, FacingPose({0.3, 0.22, 1}, 0.4));
  const LinearImage small = RenderLight(SceneOf({marker}), options);
  // The same scene in a larger frame about the same principal point.
  options.camera.width += 200;
  options.camera.height += 200;
  options.camera.cx += 100;
  options.camera.cy += 100;
  const LinearImage large = RenderLight(SceneOf({marker}), options);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      ASSERT_NEAR(small.Pixel(x, y)[0], large.Pixel(x + 100, y + 100)[0], 1e-4f) << x << ", " << y;
}

TEST(Render, EveryFormatHasItsSizeAndCurve) {
  RenderOptions options = PinholeOptions(64, 48);
  options.tone_curve = ToneCurve::Gamma(2.0);
  const Scene scene = SceneOf({Marker(Secded(), 3, FacingPose({0, 0, 3}, 0))});
  for (int i = 0; i <= static_cast<int>(PixelFormat::kYuv444p); ++i) {
    options.format = static_cast<PixelFormat>(i);
    const Image image = Render(scene, options, 1);
    EXPECT_EQ(image.format(), options.format);
    EXPECT_EQ(image.bytes().size(), PackedSize(options.format, 64, 48));
    EXPECT_EQ(image.view().tone_curve(), options.tone_curve);
  }
}

TEST(Render, JpegKeepsFormatAndCurve) {
  RenderOptions options = PinholeOptions(64, 48);
  options.jpeg_quality = 80;
  options.tone_curve = ToneCurve::Gamma(1.8);
  for (const PixelFormat format :
       {PixelFormat::kBgr8, PixelFormat::kMono8, PixelFormat::kYuv420p, PixelFormat::kYuv422p}) {
    options.format = format;
    const Image image = Render(SceneOf({}), options, 1);
    EXPECT_EQ(image.format(), format);
    EXPECT_EQ(image.view().tone_curve(), options.tone_curve);
  }
}

TEST(Render, JpegOfOddSizesShowsTheSameScene) {
  const MarkerCode code = Secded();
  const Scene scene = SceneOf({Marker(code, 77, FacingPose({0, 0, 1.5}, 0.3))});
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kRgb8, PixelFormat::kMono8, PixelFormat::kYuv420p,
                                   PixelFormat::kYuv422p, PixelFormat::kYuv444p}) {
    RenderOptions options = PinholeOptions(97, 75);
    options.format = format;
    options.blur_sigma_px = 2;
    const Image plain = Render(scene, options, 1);
    options.jpeg_quality = 95;
    const Image coded = Render(scene, options, 1);
    ASSERT_EQ(coded.bytes().size(), plain.bytes().size());
    double difference = 0;
    for (std::size_t i = 0; i < plain.bytes().size(); ++i) difference += std::abs(coded.bytes()[i] - plain.bytes()[i]);
    EXPECT_LT(difference / static_cast<double>(plain.bytes().size()), 4) << PixelFormatName(format);
  }
}

TEST(Render, SameArgumentsSameBytes) {
  RenderOptions options = PinholeOptions(160, 120);
  Scene scene = SceneOf({Marker(Secded(), 3, FacingPose({0, 0, 2}, 0))});
  scene.background.kind = BackgroundKind::kMixed;
  scene.background.seed = 9;
  const auto bytes = [&](std::uint64_t seed) {
    const Image image = Render(scene, options, seed);
    return std::vector<std::uint8_t>(image.bytes().begin(), image.bytes().end());
  };
  EXPECT_EQ(bytes(1), bytes(1));
  EXPECT_NE(bytes(1), bytes(2));
}

TEST(Renderer, FramesEqualThoseOfRender) {
  const RenderOptions options = PinholeOptions(160, 120);
  Scene scene = SceneOf({Marker(Secded(), 3, FacingPose({0, 0, 2}, 0))});
  scene.background.kind = BackgroundKind::kTiles;
  const Renderer renderer(options, scene.background);
  const Image a = renderer.Render(scene.markers, 7), b = Render(scene, options, 7);
  EXPECT_TRUE(std::equal(a.bytes().begin(), a.bytes().end(), b.bytes().begin(), b.bytes().end()));
}

TEST(RenderOptions, CheckNamesWhatIsWrong) {
  EXPECT_EQ(RenderOptions{}.Check(), "");
  RenderOptions options;
  options.camera.width = 641;
  options.format = PixelFormat::kYuyv;
  EXPECT_THAT(options.Check(), HasSubstr("even"));
  options = {};
  options.jpeg_quality = 0;
  EXPECT_THAT(options.Check(), HasSubstr("jpeg_quality"));
  options.jpeg_quality = 50;
  options.format = PixelFormat::kBayerRg8;
  EXPECT_THAT(options.Check(), HasSubstr("BayerRG8"));
  options = {};
  options.blur_sigma_px = -1;
  EXPECT_THAT(options.Check(), HasSubstr("blur_sigma_px"));
  options = {};
  options.shadow.takes = 1.1;
  EXPECT_THAT(options.Check(), HasSubstr("shadow.takes"));
  options.shadow = {.width_px = 0};
  EXPECT_THAT(options.Check(), HasSubstr("shadow.width_px"));
  EXPECT_THROW(Render({}, options, 1), std::runtime_error);
}

}  // namespace
}  // namespace chequer
