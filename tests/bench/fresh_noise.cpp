#include "bench/fresh_noise.h"

#include <algorithm>
#include <cmath>

#include "chequer/check.h"
#include "simulate/random.h"

namespace chequer::bench {
namespace {

constexpr int kSteps = CleanFrame::kStepsPerRoot;
constexpr int kLargestRoot = 65535;
constexpr std::size_t kNoiseLength = std::size_t{1} << 22;

/// The colour (0 red, 1 green, 2 blue) of each pixel of a 2 × 2 quad, row by row.
std::array<std::size_t, 4> ColoursOf(PixelFormat bayer) {
  switch (bayer) {
    case PixelFormat::kBayerRg8: return {0, 1, 1, 2};
    case PixelFormat::kBayerGb8: return {1, 2, 0, 1};
    case PixelFormat::kBayerGr8: return {1, 0, 2, 1};
    default: return {2, 1, 1, 0};
  }
}

}  // namespace

CleanFrame MakeCleanFrame(LinearImage light, const RenderOptions& camera) {
  const SensorOptions& sensor = camera.sensor;
  CHEQUER_CHECK(IsBayer(camera.format), "clean frames are Bayer frames");
  CHEQUER_CHECK(sensor.full_well_electrons <= 200'000, "roots of more electrons do not fit");
  Illuminate(light, camera.lighting);
  CleanFrame frame{.width = light.width,
                   .height = light.height,
                   .format = camera.format,
                   .full_well_electrons = sensor.full_well_electrons,
                   .read_noise_electrons = sensor.read_noise_electrons,
                   .roots = {}};
  frame.roots.reserve(static_cast<std::size_t>(light.width) * static_cast<std::size_t>(light.height));
  const std::array<std::size_t, 4> quad = ColoursOf(camera.format);
  const double read_variance = sensor.read_noise_electrons * sensor.read_noise_electrons;
  for (int y = 0; y < light.height; ++y)
    for (int x = 0; x < light.width; ++x) {
      const std::size_t colour = quad[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
      const double share = light.Pixel(x, y)[colour] * sensor.exposure * sensor.white_balance[colour];
      const double electrons = std::max(0.0, share) * sensor.full_well_electrons;
      const double root = kSteps * std::sqrt(electrons + read_variance);
      frame.roots.push_back(static_cast<std::uint16_t>(std::min<long>(kLargestRoot, std::lround(root))));
    }
  return frame;
}

FreshNoise::FreshNoise(ToneCurve tone_curve) : tone_curve_(tone_curve), value_of_root_(kLargestRoot + 1) {
  constexpr std::uint64_t kSeed = 20;
  Random random(kSeed);
  noise_.reserve(kNoiseLength);
  for (std::size_t i = 0; i < kNoiseLength; ++i)
    noise_.push_back(static_cast<std::int16_t>(std::lround(0.5 * kSteps * random.Normal())));
  for (int i = 0; i < 65536; ++i)
    value_of_light_.push_back(static_cast<std::uint8_t>(tone_curve.FromLinear(i / 65535.0) * 255 + 0.5));
}

void FreshNoise::SetSensor(double full_well_electrons, double read_noise_electrons) {
  if (full_well_electrons == full_well_electrons_ && read_noise_electrons == read_noise_electrons_) return;
  full_well_electrons_ = full_well_electrons;
  read_noise_electrons_ = read_noise_electrons;
  // The mean of a root's square is larger than the square of its mean, by the variance.
  const double excess = read_noise_electrons * read_noise_electrons + 0.25;
  for (int i = 0; i <= kLargestRoot; ++i) {
    const double root = static_cast<double>(i) / kSteps;
    const double light = std::clamp((root * root - excess) / full_well_electrons, 0.0, 1.0);
    value_of_root_[static_cast<std::size_t>(i)] = value_of_light_[static_cast<std::size_t>(light * 65535 + 0.5)];
  }
}

void FreshNoise::Expose(const CleanFrame& frame, std::uint64_t seed, Image& image) {
  SetSensor(frame.full_well_electrons, frame.read_noise_electrons);
  if (image.width() != frame.width || image.height() != frame.height || image.format() != frame.format)
    image = Image(frame.format, frame.width, frame.height, tone_curve_);
  Random random(seed);
  const auto width = static_cast<std::size_t>(frame.width);
  const std::uint16_t* root = frame.roots.data();
  std::uint8_t* out = image.bytes().data();
  for (int y = 0; y < frame.height; ++y, root += width, out += width) {
    const std::int16_t* noise = &noise_[random.Bits() % (kNoiseLength - width)];
    for (std::size_t x = 0; x < width; ++x)
      out[x] = value_of_root_[static_cast<std::size_t>(std::clamp(root[x] + noise[x], 0, kLargestRoot))];
  }
}

}  // namespace chequer::bench
