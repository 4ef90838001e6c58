#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "chequer/image.h"
#include "simulate/linear_image.h"
#include "simulate/processing.h"

namespace chequer {

/// How a sensor sees colour.
enum class SensorKind : std::uint8_t {
  kBayer,    ///< one colour a pixel, as nearly all cameras; colour images come from bilinear demosaicing
  kPerfect,  ///< three colours a pixel
};

/// From light to raw values.
struct SensorOptions {
  SensorKind kind = SensorKind::kBayer;
  /// Of kBayer where the output is not itself Bayer: one of the four Bayer formats.
  PixelFormat bayer = PixelFormat::kBayerRg8;
  /// Full scale per unit of light on the sensor: 1 makes paper white (0.85) 85 % of full scale.
  double exposure = 1;
  /// What is wrong with the white balance: factors of red, green, blue before saturation.
  std::array<double, 3> white_balance{1, 1, 1};
  double full_well_electrons = 10000;  ///< at full scale; infinity: no shot noise
  double read_noise_electrons = 5;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// Light over the frame, from the middle outwards and from side to side.
struct LightingOptions {
  double gradient = 0;            ///< light falls from 1 at one side of the frame to 1 − gradient at the other; 0..1
  double gradient_angle_rad = 0;  ///< where it falls to: 0 right, π/2 down
  double vignetting =
      0;  ///< part of the light that is missing in the corners, growing with the square of the radius; 0..1
  /// Part of the light that is replaced by even white light, 0..0.95: haze, a dirty window, stray light.
  double haze = 0;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// Applies gradient, vignetting and haze.
void Illuminate(LinearImage& image, const LightingOptions& lighting);

/// The 8-bit image that the sensor gives through its tone curve: `format` is kBgr8, kRgb8, kMono8 (a sensor without
/// colour filters) or one of the Bayer formats (raw, also coded with the curve). Noise hangs on the seed alone.
/// @param processing of which the saturation (not of Mono8 and raw images) and the curve are applied here.
/// @pre options.Check() is empty.
Image Expose(const LinearImage& light, const SensorOptions& options, PixelFormat format, ToneCurve tone_curve,
             std::uint64_t seed, const ProcessingOptions& processing = {});

}  // namespace chequer
