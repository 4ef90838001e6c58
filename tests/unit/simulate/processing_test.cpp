#include "simulate/processing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulate/render.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

RenderOptions NoiselessOptions() {
  RenderOptions options;
  options.camera = {.width = 96, .height = 64, .fx = 100, .fy = 100, .cx = 47.5, .cy = 31.5};
  options.sensor.kind = SensorKind::kPerfect;
  options.sensor.full_well_electrons = std::numeric_limits<double>::infinity();
  return options;
}

/// Dark to the left of a column, light to its right.
LinearImage Edge(int column, float light = 0.5f) {
  LinearImage image(96, 64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 96; ++x) std::fill_n(image.Pixel(x, y), 3, x < column ? 0.1f : light);
  return image;
}

std::uint8_t ValueAt(const Image& image, int x, int y, int channel = 0) { return image.view().row(y)[3 * x + channel]; }

TEST(Processing, NothingIsDoneUnlessAskedFor) {
  const RenderOptions options = NoiselessOptions();
  EXPECT_FALSE(options.processing.any());
  const Image plain = Capture(Edge(48), options, 1);
  RenderOptions same = options;
  same.processing.curve = {CameraCurve::Kind::kGamma, 1};
  same.tone_curve = ToneCurve::Linear();
  RenderOptions linear = options;
  linear.tone_curve = ToneCurve::Linear();
  const Image a = Capture(Edge(48), same, 1), b = Capture(Edge(48), linear, 1);
  EXPECT_TRUE(std::equal(a.bytes().begin(), a.bytes().end(), b.bytes().begin(), b.bytes().end()));
}

TEST(Processing, SharpeningOvershootsEdgesAndLeavesPlainPartsAlone) {
  RenderOptions options = NoiselessOptions();
  const Image plain = Capture(Edge(48), options, 1);
  options.processing.sharpening = 0.5;
  const Image sharp = Capture(Edge(48), options, 1);
  EXPECT_EQ(ValueAt(sharp, 20, 30), ValueAt(plain, 20, 30));
  EXPECT_GT(ValueAt(sharp, 48, 30), ValueAt(plain, 48, 30) + 10);
  EXPECT_LT(ValueAt(sharp, 47, 30), ValueAt(plain, 47, 30) - 10);
}

TEST(Processing, DenoisingTakesNoiseAndKeepsEdges) {
  RenderOptions options = NoiselessOptions();
  options.sensor.full_well_electrons = 3000;
  const auto roughness = [](const Image& image) {
    double sum = 0;
    for (int y = 10; y < 50; ++y)
      for (int x = 10; x < 40; ++x) sum += std::abs(ValueAt(image, x, y) - ValueAt(image, x + 1, y));
    return sum;
  };
  const Image plain = Capture(Edge(48), options, 1);
  options.processing.denoising_levels = 10;
  const Image calm = Capture(Edge(48), options, 1);
  EXPECT_LT(roughness(calm), 0.6 * roughness(plain));
  EXPECT_GT(ValueAt(calm, 48, 30) - ValueAt(calm, 47, 30), 80);
}

TEST(Processing, SaturationMovesColoursFromGreyAndGreyNot) {
  RenderOptions options = NoiselessOptions();
  options.processing.saturation = 1.5;
  LinearImage light(96, 64);
  for (std::size_t i = 0; i < light.rgb.size(); ++i) light.rgb[i] = i % 3 == 0 ? 0.5f : 0.3f;
  const Image red = Capture(light, options, 1), grey = Capture(Edge(0), options, 1);
  EXPECT_GT(ToneCurve::Srgb().ToLinear(ValueAt(red, 9, 9, 2) / 255.0), 0.55);
  EXPECT_EQ(ValueAt(grey, 9, 9, 0), ValueAt(grey, 9, 9, 2));
}

TEST(Processing, ForeignCurvesAreNotStated) {
  RenderOptions options = NoiselessOptions();
  options.processing.curve = *ParseCameraCurve("gamma:1.4");
  const Image image = Capture(Edge(0, 0.4f), options, 1);
  EXPECT_EQ(image.view().tone_curve(), ToneCurve::Srgb());
  EXPECT_NEAR(ValueAt(image, 9, 9), 255 * std::pow(0.4, 1 / 1.4), 1);
  options.processing.curve = *ParseCameraCurve("bt709");
  EXPECT_NEAR(ValueAt(Capture(Edge(0, 0.4f), options, 1), 9, 9), 255 * (1.099 * std::pow(0.4, 0.45) - 0.099), 1);
  for (const char* curve : {"gamma:1.4", "bt709", "knee:0.6"}) {
    const CameraCurve parsed = *ParseCameraCurve(curve);
    EXPECT_NEAR(parsed.CodeOf(1, ToneCurve::Srgb()), 1, 1e-6) << curve;
    EXPECT_NEAR(parsed.CodeOf(0, ToneCurve::Srgb()), 0, 1e-6) << curve;
  }
  for (const char* wrong : {"", "gamma", "gamma:9", "knee:2", "knee:0.6x", "sepia:1"})
    EXPECT_FALSE(ParseCameraCurve(wrong)) << wrong;
}

TEST(Processing, ChromaticAberrationMovesRedOutAndBlueIn) {
  RenderOptions options = NoiselessOptions();
  options.tone_curve = ToneCurve::Linear();
  options.processing.chromatic_aberration_px = 1;
  const Image image = Capture(Edge(80), options, 1);
  // The edge lies 32 of 58 px out, light beyond it: red's is farther out, so that the first light column lacks red.
  EXPECT_LT(ValueAt(image, 80, 32, 2), ValueAt(image, 80, 32, 1) - 20);
  EXPECT_GT(ValueAt(image, 79, 32, 0), ValueAt(image, 79, 32, 1) + 20);
}

TEST(Processing, UpscaledFramesHaveTheirSizeAndSofterEdges) {
  RenderOptions options = NoiselessOptions();
  options.tone_curve = ToneCurve::Linear();
  options.processing.upscaling = 2;
  const Image image = Capture(Edge(48), options, 1);
  EXPECT_EQ(image.width(), 96);
  EXPECT_EQ(image.height(), 64);
  EXPECT_NEAR(ValueAt(image, 48, 32), 255 * (0.1 + 0.75 * 0.4), 3);
  EXPECT_NEAR(ValueAt(image, 47, 32), 255 * (0.1 + 0.25 * 0.4), 3);
}

TEST(Processing, PresetsRenderInTheirFormats) {
  for (const char* name : {"webcam-mjpeg", "webcam-yuyv", "webcam-nv12"}) {
    const auto preset = FindCameraPreset(name);
    ASSERT_TRUE(preset) << name;
    RenderOptions options = NoiselessOptions();
    options.format = preset->format;
    options.jpeg_quality = preset->jpeg_quality;
    options.processing = preset->processing;
    EXPECT_EQ(options.Check(), "") << name;
    EXPECT_EQ(Capture(Edge(48), options, 1).format(), preset->format) << name;
    EXPECT_THAT(CameraPresetNames(), HasSubstr(name));
  }
  EXPECT_FALSE(FindCameraPreset("webcam"));
}

TEST(ProcessingOptions, CheckNamesWhatIsWrong) {
  ProcessingOptions options;
  EXPECT_EQ(options.Check(), "");
  options.sharpening = 9;
  EXPECT_THAT(options.Check(), HasSubstr("sharpening"));
  options = {};
  options.upscaling = 0.5;
  EXPECT_THAT(options.Check(), HasSubstr("upscaling"));
  RenderOptions raw = NoiselessOptions();
  raw.format = PixelFormat::kBayerRg8;
  EXPECT_EQ(raw.Check(), "");
  raw.processing.sharpening = 1;
  EXPECT_THAT(raw.Check(), HasSubstr("raw"));
}

}  // namespace
}  // namespace chequer
