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

/// Of so many light pixels a channel, the slope that all have in common is known to a tenth. Of fewer, as of
/// overexposed boards, whose others are saturated, it leans in that proportion on the slope of shot noise alone, which
/// the dark cells tell: those are so light there that read noise does not matter. (Measured: without this, two fits of
/// one board in one frame had slopes that differed by two thirds, by 60 light pixels each.)
constexpr double kTellCommonSlope = 200;
/// Channels have that line in common, each by what its own noise is: white balance scales shot noise by its gain and
/// read noise by the gain's square. It counts as much as so many light pixels of a channel beside what these tell: a
/// board has 350 to 700, of which those that a motion blurs tell a slope to a fifth. (Measured: poses of knocked frames
/// with and without memory, whose first boards differ, do so by .099 instead of .109 deviations in one of three
/// streams; with as much as 200 or 4,000 pixels by .102 or .096, but overexposed ones as with this at best.)
constexpr double kCommonLine = 800;

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

/// Variance by light.
struct Line {
  double floor, slope;
};

/// Through what the dark pixels have.
Line LineOf(const Half& dark, double slope, double freedom) {
  const double variance = dark.Variance(freedom);
  return {std::max(variance - slope * dark.MeanLight(), 0.02 * variance), slope};
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
  const double of_all = freedom((all_dark.count + all_light.count) / channels),
               of_photons = all_dark.Variance(of_all) / std::max(all_dark.MeanLight(), 1e-6),
               told = std::min(all_light.count / channels / kTellCommonSlope, 1.0);
  const Line common = LineOf(all_dark, std::lerp(of_photons, SlopeOf(all_dark, all_light, of_all), told), of_all);
  for (std::size_t c = 0; c < 3; ++c) {
    Half all = dark[c];
    all += light[c];
    if (dark[c].count < kFewestPixels || weight[c] - all.count > kMostOff * weight[c]) continue;
    const double of_own = freedom(all.count), share = light[c].count / (light[c].count + kCommonLine);
    const Line own = light[c].count > 0 ? LineOf(dark[c], SlopeOf(dark[c], light[c], of_own), of_own) : common;
    const double scale = all.Variance(of_own) / (common.floor + common.slope * all.MeanLight());
    noise.floor[c] = static_cast<float>(std::lerp(scale * common.floor, own.floor, share));
    noise.slope[c] = static_cast<float>(std::lerp(scale * common.slope, own.slope, share));
  }
}

}  // namespace chequer
