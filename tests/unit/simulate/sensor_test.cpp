#include "simulate/sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace chequer {
namespace {

LinearImage Flat(int width, int height, float r, float g, float b) {
  LinearImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float* pixel = image.Pixel(x, y);
      pixel[0] = r;
      pixel[1] = g;
      pixel[2] = b;
    }
  return image;
}

SensorOptions Noiseless() {
  SensorOptions options;
  options.full_well_electrons = std::numeric_limits<double>::infinity();
  return options;
}

TEST(Expose, EachBayerPhasePutsItsColoursWhereGenICamSays) {
  const LinearImage light = Flat(4, 4, 0.2f, 0.5f, 0.9f);
  const auto colour_at = [](std::string_view name, int x, int y) {
    // "BayerRG8": the first row begins R G; its second row is G B, as green lies on the other diagonal.
    const char first = name[5], second = name[6];
    const std::string quad = first == 'G' ? std::string{first, second, second == 'B' ? 'R' : 'B', 'G'}
                                          : std::string{first, second, 'G', first == 'R' ? 'B' : 'R'};
    return quad[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
  };
  for (const PixelFormat format :
       {PixelFormat::kBayerRg8, PixelFormat::kBayerGb8, PixelFormat::kBayerGr8, PixelFormat::kBayerBg8}) {
    const Image image = Expose(light, Noiseless(), format, ToneCurve::Linear(), 1);
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x) {
        const char colour = colour_at(PixelFormatName(format), x, y);
        const double expected = colour == 'R' ? 0.2 : (colour == 'G' ? 0.5 : 0.9);
        EXPECT_NEAR(image.view().row(y)[x], 255 * expected, 0.51) << PixelFormatName(format) << " " << x << " " << y;
      }
  }
}

TEST(Expose, DemosaicingGivesTheColourBackFromEveryPhase) {
  const LinearImage light = Flat(8, 6, 0.2f, 0.5f, 0.9f);
  for (const PixelFormat bayer :
       {PixelFormat::kBayerRg8, PixelFormat::kBayerGb8, PixelFormat::kBayerGr8, PixelFormat::kBayerBg8}) {
    SensorOptions options = Noiseless();
    options.bayer = bayer;
    const Image bgr = Expose(light, options, PixelFormat::kBgr8, ToneCurve::Linear(), 1);
    const Image rgb = Expose(light, options, PixelFormat::kRgb8, ToneCurve::Linear(), 1);
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x) {
        EXPECT_NEAR(bgr.view().row(y)[3 * x], 230, 1);
        EXPECT_NEAR(bgr.view().row(y)[3 * x + 1], 128, 1);
        EXPECT_NEAR(bgr.view().row(y)[3 * x + 2], 51, 1);
        EXPECT_EQ(rgb.view().row(y)[3 * x], bgr.view().row(y)[3 * x + 2]);
      }
  }
}

TEST(Expose, DemosaicingMixesNeighboursLinearly) {
  // One bright red photosite: bilinear demosaicing gives half of it to the two pixels beside it.
  LinearImage light = Flat(9, 9, 0, 0, 0);
  light.Pixel(4, 4)[0] = 0.8f;
  const Image image = Expose(light, Noiseless(), PixelFormat::kBgr8, ToneCurve::Linear(), 1);
  EXPECT_NEAR(image.view().row(4)[3 * 4 + 2], 204, 1);
  EXPECT_NEAR(image.view().row(4)[3 * 5 + 2], 102, 1);
  EXPECT_NEAR(image.view().row(3)[3 * 3 + 2], 51, 1);
  EXPECT_EQ(image.view().row(4)[3 * 4 + 1], 0);
}

TEST(Expose, NoiseHasThePhotonsAndTheReadOutsVariance) {
  SensorOptions options;
  options.kind = SensorKind::kPerfect;
  for (const double full_well : {300.0, 3000.0}) {
    options.full_well_electrons = full_well;
    options.read_noise_electrons = 8;
    const double light = 0.4;
    const Image image = Expose(Flat(200, 200, 0.4f, 0.4f, 0.4f), options, PixelFormat::kBgr8, ToneCurve::Linear(), 5);
    double sum = 0, squares = 0;
    for (const std::uint8_t value : image.bytes()) {
      sum += value;
      squares += static_cast<double>(value) * value;
    }
    const auto count = static_cast<double>(image.bytes().size());
    const double mean = sum / count, variance = squares / count - mean * mean;
    const double expected = (light * full_well + 64) / (full_well * full_well) * 255 * 255 + 1 / 12.0;
    EXPECT_NEAR(mean, 255 * light, 0.3) << full_well;
    EXPECT_NEAR(variance / expected, 1, 0.03) << full_well;
  }
}

TEST(Expose, SaturatesAndAppliesExposureAndWhiteBalance) {
  SensorOptions options = Noiseless();
  options.kind = SensorKind::kPerfect;
  options.exposure = 2;
  options.white_balance = {0.5, 1, 2};
  const Image image = Expose(Flat(2, 2, 0.3f, 0.3f, 0.3f), options, PixelFormat::kRgb8, ToneCurve::Linear(), 1);
  EXPECT_NEAR(image.bytes()[0], 0.3 * 255, 1);
  EXPECT_NEAR(image.bytes()[1], 0.6 * 255, 1);
  EXPECT_EQ(image.bytes()[2], 255);
}

TEST(Expose, CodesWithTheToneCurve) {
  for (const ToneCurve curve : {ToneCurve::Srgb(), ToneCurve::Gamma(2.2), ToneCurve::Linear()}) {
    const Image image = Expose(Flat(2, 2, 0.25f, 0.25f, 0.25f), Noiseless(), PixelFormat::kMono8, curve, 1);
    EXPECT_NEAR(image.bytes()[0], 255 * curve.FromLinear(0.25), 0.51) << curve.Name();
    EXPECT_EQ(image.view().tone_curve(), curve);
  }
}

TEST(Expose, SeedAloneDecidesTheNoise) {
  const LinearImage light = Flat(16, 16, 0.4f, 0.4f, 0.4f);
  const auto bytes = [&](std::uint64_t seed) {
    const Image image = Expose(light, SensorOptions{}, PixelFormat::kBgr8, ToneCurve::Srgb(), seed);
    return std::vector<std::uint8_t>(image.bytes().begin(), image.bytes().end());
  };
  EXPECT_EQ(bytes(3), bytes(3));
  EXPECT_NE(bytes(3), bytes(4));
}

TEST(Illuminate, GradientFallsFromOneSideToTheOther) {
  LinearImage image = Flat(100, 20, 1, 1, 1);
  Illuminate(image, {.gradient = 0.6, .gradient_angle_rad = 0});
  EXPECT_NEAR(image.Pixel(0, 10)[0], 1, 0.01);
  EXPECT_NEAR(image.Pixel(99, 10)[0], 0.4, 0.01);
  EXPECT_NEAR(image.Pixel(50, 3)[0], 0.7, 0.01);
}

TEST(Illuminate, VignettingDarkensTheCorners) {
  LinearImage image = Flat(101, 101, 1, 1, 1);
  Illuminate(image, {.vignetting = 0.5});
  EXPECT_NEAR(image.Pixel(50, 50)[1], 1, 1e-6);
  EXPECT_NEAR(image.Pixel(0, 0)[1], 0.5, 0.02);
  EXPECT_NEAR(image.Pixel(0, 50)[1], 0.75, 0.02);
}

TEST(Illuminate, HazeLaysAVeilOverBlackAndTakesFromWhite) {
  LinearImage image = Flat(2, 1, 0, 0.5f, 1);
  Illuminate(image, {.haze = 0.2});
  EXPECT_NEAR(image.Pixel(0, 0)[0], 0.2, 1e-6);
  EXPECT_NEAR(image.Pixel(0, 0)[1], 0.6, 1e-6);
  EXPECT_NEAR(image.Pixel(0, 0)[2], 1, 1e-6);
}

TEST(SensorOptions, CheckNamesWhatIsWrong) {
  EXPECT_EQ(SensorOptions{}.Check(), "");
  SensorOptions options;
  options.exposure = 0;
  EXPECT_THAT(options.Check(), ::testing::HasSubstr("exposure"));
  options = {};
  options.bayer = PixelFormat::kBgr8;
  EXPECT_THAT(options.Check(), ::testing::HasSubstr("BayerRG8"));
  EXPECT_THAT(LightingOptions{.haze = 2}.Check(), ::testing::HasSubstr("haze"));
}

}  // namespace
}  // namespace chequer
