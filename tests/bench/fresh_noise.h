#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "chequer/image.h"
#include "simulate/linear_image.h"
#include "simulate/render.h"

namespace chequer::bench {

/// A Bayer frame before its noise. Each pixel holds √(electrons + read noise²): in that measure the noise of photons
/// and of reading is Gaussian with a standard deviation of ½ whatever the light (Anscombe, 1948), so that noise is a
/// sum.
struct CleanFrame {
  int width = 0;
  int height = 0;
  PixelFormat format = PixelFormat::kBayerRg8;
  double full_well_electrons = 0;
  double read_noise_electrons = 0;
  std::vector<std::uint16_t> roots;  ///< row by row, kStepsPerRoot to 1

  static constexpr int kStepsPerRoot = 128;
};

/// What Capture adds noise to. @pre camera.format is a Bayer format, camera.Check() is empty, and the full well is at
/// most 200,000 electrons.
CleanFrame MakeCleanFrame(LinearImage light, const RenderOptions& camera);

/// Gives clean frames new noise, as SensorOptions has it, in about a nanosecond a pixel. The noise comes from a table
/// of four million normal numbers, each row of a frame from another place. One thread at a time.
class FreshNoise {
 public:
  explicit FreshNoise(ToneCurve tone_curve);

  /// The frame with the noise of that seed. The same arguments give the same bytes. `image` keeps its memory where it
  /// has the frame's size and format.
  void Expose(const CleanFrame& frame, std::uint64_t seed, Image& image);

 private:
  /// Values of roots, for the sensor of a frame.
  void SetSensor(double full_well_electrons, double read_noise_electrons);

  ToneCurve tone_curve_;
  std::vector<std::int16_t> noise_;
  std::vector<std::uint8_t> value_of_light_;  ///< of 65,536 steps
  std::vector<std::uint8_t> value_of_root_;
  double full_well_electrons_ = 0;
  double read_noise_electrons_ = -1;
};

}  // namespace chequer::bench
