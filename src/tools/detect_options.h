#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "chequer/detector.h"
#include "chequer/image.h"
#include "setup/camera_setup.h"
#include "tools/marker_options.h"

namespace chequer {

/// The options that say how images are to be read and searched, as typed. Several commands share them.
struct DetectOptions {
  std::string config;                ///< supplies what the others leave out
  std::optional<CameraSetup> setup;  ///< what it says, once TakeSetup has read it
  MarkerOptions markers;
  std::string calibration;
  std::string pixel_format = "Mono8";
  std::optional<double> gamma;
  std::string color_space;      ///< empty: the configuration's, else lab
  std::string print_tolerance;  ///< empty: the configuration's, else none
  int threads = 1;

  /// Whether options or the configuration say what kind of marker is sought.
  bool NamesKind() const { return markers.names_kind || (setup && !setup->families.empty()); }
};

/// Adds --config, --marker and the like, --calibration, --pixel-format, --gamma and --color-space to a command.
/// `options` must outlive the parsing.
void AddDetectOptions(CLI::App& command, DetectOptions& options);

/// Reads the configuration, if there is one, and takes its calibration where none is typed. A calibration that is not
/// there yet is said on standard error, and left out. Throws std::runtime_error where a file is not right.
void TakeSetup(DetectOptions& options, const char* command);
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
