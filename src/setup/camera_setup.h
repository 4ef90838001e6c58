#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/source_factory.h"
#include "chequer/detector.h"

namespace chequer {

/// What a configuration of chequerd says of a camera, its markers, world and robots. The files it names need not be
/// there yet: calibrations write them.
struct CameraSetup {
  std::filesystem::path file;                        ///< the configuration
  std::string camera_name;                           ///< empty: left out
  std::optional<CaptureOptions> capture;             ///< nothing without [capture]
  std::vector<MarkerFamily> families;                ///< none without [[marker]]; a side that is left out is 0
  ColorSpace color_space = ColorSpace::kLab;         ///< [detect]
  PrintTolerance print_tolerance;                    ///< [print]
  std::optional<std::filesystem::path> calibration;  ///< the camera file
  std::optional<std::filesystem::path> world;
  std::optional<std::filesystem::path> robots;
  std::optional<std::string> publish_url;     ///< [publish] url
  std::optional<std::string> publish_prefix;  ///< [publish] prefix
  std::optional<bool> allow_view;             ///< [view] allow
};

/// Reads those keys; chequerd checks the others. Throws std::runtime_error naming file, line, key, value and what would
/// be right.
CameraSetup LoadCameraSetup(const std::filesystem::path& file);

/// The configuration that every command takes where none is named.
inline constexpr const char* kSetupHere = "chequer.toml";
/// Where the service's configurations are: NAME.toml of the camera NAME.
inline constexpr const char* kServiceFolder = "/etc/chequer";

/// The file that `--config` means: a path (with a "/", or that ends in .toml) as it is; of a name the first of
/// NAME.toml in the folders. Throws std::runtime_error that says where it was looked for, and what is there.
/// @param folders where a name is looked for, the first first.
std::filesystem::path FindCameraSetup(const std::string& typed, std::span<const std::filesystem::path> folders);
/// The same in the current folder and kServiceFolder.
std::filesystem::path FindCameraSetup(const std::string& typed);

}  // namespace chequer
