#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "setup/camera_setup.h"

namespace chequer {

/// Adds `--config`. @param supplies what the command takes from it, for the help.
CLI::Option* AddSetupOption(CLI::App& command, std::string& config, const std::string& supplies);

/// Adds `--url` to a command that listens to LCM; empty where it is not typed.
void AddListenUrlOption(CLI::App& command, std::string& url);

/// What the configuration says: the one that is typed, else ./chequer.toml, which is then said on standard error;
/// nothing where there is neither. Throws std::runtime_error where it is not right.
std::optional<CameraSetup> LoadSetup(const std::string& typed);

/// The name of its camera: the configuration's, else its file's.
std::string CameraNameIn(const CameraSetup& setup);
/// The prefix of its channels.
std::string PrefixIn(const CameraSetup& setup);
/// The LCM URL where its messages are heard.
std::string ListenUrlIn(const CameraSetup& setup);

/// The file that an option names, else the configuration; throws CLI::ValidationError that names the option and the key
/// where neither does.
/// @param key such as "calibration in [camera]".
std::filesystem::path FileOf(const char* option, const std::string& typed, const std::optional<CameraSetup>& setup,
                             const std::optional<std::filesystem::path>& in_setup, const char* key);

}  // namespace chequer
