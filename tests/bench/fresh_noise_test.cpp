#include "bench/fresh_noise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace chequer::bench {
namespace {

constexpr int kNoiseSide = 128;

LinearImage EvenLight(float light) {
  LinearImage image(kNoiseSide, kNoiseSide);
  std::fill(image.rgb.begin(), image.rgb.end(), light);
  return image;
}

RenderOptions NoisyCamera(double gain = 1) {
  RenderOptions camera;
  camera.camera.width = camera.camera.height = kNoiseSide;
  camera.format = PixelFormat::kBayerRg8;
  camera.sensor.full_well_electrons /= gain;
  return camera;
}

struct Values {
  double mean = 0, deviation = 0;
};

Values ValuesOf(const Image& image) {
  Values values;
  const auto bytes = image.bytes();
  const auto count = static_cast<double>(bytes.size());
  for (const std::uint8_t value : bytes) values.mean += value / count;
  for (const std::uint8_t value : bytes) values.deviation += std::pow(value - values.mean, 2) / count;
  values.deviation = std::sqrt(values.deviation);
  return values;
}

TEST(FreshNoise, IsThatOfTheSensor) {
  FreshNoise noise(ToneCurve::Srgb());
  for (const double gain : {1.0, 8.0})
    for (const float light : {0.003f, 0.02f, 0.1f, 0.4f, 0.85f, 0.99f, 1.5f}) {
      const RenderOptions camera = NoisyCamera(gain);
      Image image;
      noise.Expose(MakeCleanFrame(EvenLight(light), camera), 7, image);
      const Values fresh = ValuesOf(image), sensor = ValuesOf(Capture(EvenLight(light), camera, 7));
      // Of 16,384 pixels a mean errs by a hundredth of the deviation, and the deviation by half of that.
      EXPECT_NEAR(fresh.mean, sensor.mean, 0.05 * sensor.deviation + 1e-9) << light << " at gain " << gain;
      EXPECT_NEAR(fresh.deviation, sensor.deviation, 0.03 * sensor.deviation + 1e-9) << light << " at gain " << gain;
    }
}

TEST(FreshNoise, KeepsTheMosaicAndTheLighting) {
  LinearImage light = EvenLight(0);
  for (std::size_t i = 0; i < light.rgb.size(); i += 3) light.rgb[i] = 0.5f;
  RenderOptions camera = NoisyCamera();
  camera.lighting.gradient = 0.8;
  camera.sensor.white_balance = {0.9, 1, 1};
  FreshNoise noise(ToneCurve::Srgb());
  for (const PixelFormat format :
       {PixelFormat::kBayerRg8, PixelFormat::kBayerGb8, PixelFormat::kBayerGr8, PixelFormat::kBayerBg8}) {
    camera.format = format;
    Image image;
    noise.Expose(MakeCleanFrame(light, camera), 3, image);
    const Image expected = Capture(light, camera, 3);
    ASSERT_EQ(image.format(), format);
    for (std::size_t i = 0; i < image.bytes().size(); ++i)
      ASSERT_NEAR(image.bytes()[i], expected.bytes()[i], 24) << "pixel " << i << " of " << PixelFormatName(format);
  }
}

TEST(FreshNoise, HangsOnTheSeedAlone) {
  FreshNoise noise(ToneCurve::Srgb());
  const CleanFrame frame = MakeCleanFrame(EvenLight(0.3f), NoisyCamera());
  Image first, again, other;
  noise.Expose(frame, 1, first);
  noise.Expose(MakeCleanFrame(EvenLight(0.9f), NoisyCamera(4)), 1, other);
  noise.Expose(frame, 1, again);
  noise.Expose(frame, 2, other);
  EXPECT_TRUE(std::ranges::equal(first.bytes(), again.bytes()));
  // Noise of two seeds has nothing in common, neither from pixel to pixel nor from row to row.
  const double mean = ValuesOf(first).mean, deviation = ValuesOf(first).deviation;
  const auto correlation = [&](const Image& a, const Image& b, std::size_t shift) {
    double sum = 0;
    const std::size_t count = a.bytes().size() - shift;
    for (std::size_t i = 0; i < count; ++i) sum += (a.bytes()[i] - mean) * (b.bytes()[i + shift] - mean);
    return sum / (static_cast<double>(count) * deviation * deviation);
  };
  EXPECT_NEAR(correlation(first, again, 0), 1, 0.01);
  EXPECT_NEAR(correlation(first, other, 0), 0, 0.05);
  EXPECT_NEAR(correlation(first, first, 1), 0, 0.05);
  EXPECT_NEAR(correlation(first, first, kNoiseSide), 0, 0.05);
}

}  // namespace
}  // namespace chequer::bench
