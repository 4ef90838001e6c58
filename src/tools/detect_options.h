#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "chequer/detector.h"
#include "chequer/image.h"
#include "tools/marker_options.h"

namespace chequer {

/// The options that say how images are to be read and searched, as typed. Several commands share them.
struct DetectOptions {
  MarkerOptions markers;
  std::string calibration;
  std::string pixel_format = "Mono8";
  std::optional<double> gamma;
  std::string color_space = "lab";
  int threads = 1;
};

/// Adds --marker and the like, --calibration, --pixel-format, --gamma and --color-space to a command. `options` must
/// outlive the parsing.
void AddDetectOptions(CLI::App& command, DetectOptions& options);

/// What the options ask of the detector. Throws CLI::ValidationError naming the option, what is wrong and what would be
/// right; std::runtime_error where a file cannot be read.
DetectorOptions MakeDetectorOptions(const DetectOptions& options);
/// What a one-channel file holds. Throws CLI::ValidationError.
PixelFormat ParseOneChannel(const std::string& name);
/// Throws CLI::ValidationError.
std::optional<ToneCurve> ParseGamma(std::optional<double> gamma);
/// The same pixels with another curve, where one was stated.
ImageView WithToneCurve(const ImageView& image, const std::optional<ToneCurve>& curve);
/// Throws std::runtime_error naming image and calibration where the calibration is for images of another size.
void CheckCalibrationFits(const DetectorOptions& detector, const DetectOptions& options, const std::string& name,
                          const ImageView& image);
/// Throws CLI::ValidationError naming the option.
void CheckRange(const char* option, int value, int least, int most);

}  // namespace chequer
