#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame_source.h"
#include "capture/source_factory.h"

namespace chequer {

/// Options that say where frames come from, as typed.
struct SourceRequest {
  std::string config;  ///< a configuration of chequerd; or these:
  std::string device;
  std::string source;  ///< v4l2, aravis; empty: as the device looks
  std::string pixel_format;
  std::string size;  ///< WIDTHxHEIGHT
  std::optional<double> fps;
  std::vector<std::string> settings;  ///< NAME=VALUE
  std::string calibration;            ///< a camera file; empty: the configuration's
};

/// What they mean.
struct ChosenSource {
  CaptureOptions capture;
  std::string camera = "camera";                     ///< its name
  std::optional<std::filesystem::path> calibration;  ///< a camera file
};

/// Adds --config, --device, --source, --pixel-format, --size, --fps, --set and --calibration.
void AddSourceOptions(CLI::App& command, SourceRequest& request);

/// Throws CLI::ValidationError where options contradict each other, std::runtime_error where a file is not right.
ChosenSource ChooseSource(const SourceRequest& request);

/// The [capture] table that the options mean, as a configuration would have it.
std::string CaptureText(const SourceRequest& request);

/// The source, open. Remarks go to standard error. Throws std::runtime_error with what is wrong.
std::unique_ptr<FrameSource> OpenSource(const ChosenSource& chosen, const char* command);

}  // namespace chequer
