#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace chequer {

/// `chequer calibrate lens`.
void AddCalibrateLensCommand(CLI::App& calibrate);
/// `chequer calibrate world`.
void AddCalibrateWorldCommand(CLI::App& calibrate);
/// `chequer calibrate robots`.
void AddCalibrateRobotsCommand(CLI::App& calibrate);

/// Throws CLI::ValidationError where a file cannot be written for want of a folder: better before somebody has shown a
/// sheet to a camera than after.
void CheckFolderOf(const char* option, const std::filesystem::path& file);

/// The time, as "2024-05-01T12:00:00Z".
std::string NowInUtc();

}  // namespace chequer
