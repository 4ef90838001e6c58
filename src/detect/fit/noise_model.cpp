#include "detect/fit/noise_model.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Fewer pixels do not tell a variance.
constexpr double kFewestPixels = 20;
/// Where more of the weight is that of pixels off by several deviations, the noise is not what they show: told from the
/// others alone, it would shrink from pass to pass, and leave fewer each time.
constexpr double kMostOff = 0.03;

/// Of so many light pixels, a channel's slope is known to a tenth. Of fewer, as of an overexposed board, whose others
/// are saturated, it counts by their share beside the one that all channels have in common: a camera's differ by up to
/// two, by the white balance. Of few light pixels, the common slope leans in the same way on that of shot noise alone,
/// which the dark cells tell: those of an overexposed board are so light that read noise does not matter. (Measured:
/// without this, two fits of one board in one frame had slopes that differed by two thirds, by 60 light pixels each.)
constexpr double kTellASlope = 200;

struct Half {
  double square = 0, light = 0, count = 0;  ///< of pixels that fit

  Half& operator+=(const Half& other) {
    square += other.square, light += other.light, count += other.count;
    return *this;
  }
  double Variance(double freedom) const { return std::max(freedom * square / count, 1e-9); }
  double MeanLight() const { return light / count; }
};

/// The slope between the two, by the noise of as many free pixels.
double SlopeOf(const Half& dark, const Half& light, double freedom) {
  const double rise = light.Variance(freedom) - dark.Variance(freedom), x0 = dark.MeanLight(), x1 = light.MeanLight();
  return std::clamp(rise / std::max(x1 - x0, 1e-6), 0.0, light.Variance(freedom) / std::max(x1, 1e-6));
}

}  // namespace

NoiseModel UnknownNoise(float lightest) {
  NoiseModel noise;
  noise.floor.fill(std::max(2e-5f * lightest, 1e-7f));
  noise.slope.fill(3e-4f);
  return noise;
}

void EstimateNoise(const BoardPixels& pixels, std::span<const Hidden> hidden,
                   const std::array<int, 4>& channel_of_phase, NoiseModel& noise) {
  std::array<Half, 3> dark, light;
  std::array<double, 3> weight{};
  const LaneBlock& lanes = pixels.lanes();
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (hidden[static_cast<std::size_t>(corner)] != Hidden::kNot) continue;
    for (int phase = 0; phase < 4; ++phase) {
      const int lane = pixels.Lane(corner) + phase;
      const std::size_t channel = static_cast<std::size_t>(channel_of_phase[static_cast<std::size_t>(phase)]);
      dark[channel].square += lanes.sum(kDarkSquare, lane);
      dark[channel].light += lanes.sum(kDarkLight, lane);
      dark[channel].count += lanes.sum(kDarkCount, lane);
      light[channel].square += lanes.sum(kLightSquare, lane);
      light[channel].light += lanes.sum(kLightLight, lane);
      light[channel].count += lanes.sum(kLightCount, lane);
      weight[channel] += lanes.sum(kWeight, lane) - lanes.sum(kSaturatedWeight, lane);
    }
  }
  const int cells = pixels.size().rows * pixels.size().cols;
  // Cells' levels and the geometry were fitted to the same pixels.
  const auto freedom = [&](double n) { return n / std::max(n - cells - 3.0, 0.3 * n); };
  Half all_dark, all_light;
  int channels = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (dark[c].count < kFewestPixels) continue;
    all_dark += dark[c], all_light += light[c], ++channels;
  }
  if (all_light.count < kFewestPixels) return;
  const auto told = [](double light_pixels) { return std::min(light_pixels / kTellASlope, 1.0); };
  const double of_all = freedom((all_dark.count + all_light.count) / channels),
               of_photons = all_dark.Variance(of_all) / std::max(all_dark.MeanLight(), 1e-6),
               common = std::lerp(of_photons, SlopeOf(all_dark, all_light, of_all), told(all_light.count / channels));
  for (std::size_t c = 0; c < 3; ++c) {
    const double n = dark[c].count + light[c].count;
    if (dark[c].count < kFewestPixels || weight[c] - n > kMostOff * weight[c]) continue;
    const double own = light[c].count > 0 ? SlopeOf(dark[c], light[c], freedom(n)) : common,
                 slope = std::lerp(common, own, told(light[c].count));
    const double dark_variance = dark[c].Variance(freedom(n));
    noise.floor[c] = static_cast<float>(std::max(dark_variance - slope * dark[c].MeanLight(), 0.02 * dark_variance));
    noise.slope[c] = static_cast<float>(slope);
  }
}

}  // namespace chequer
