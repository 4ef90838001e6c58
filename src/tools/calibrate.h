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

/// The same of a picture, whose name must end in .png.
void CheckPngName(const char* option, const std::filesystem::path& file);

/// What `--force` is for.
inline constexpr const char* kForceHelp = "Replace the file of --out also where somebody edited it";

/// Whether there is a file that holds something other than WriteCalibration put there: somebody edited or wrote it.
bool IsEdited(const std::filesystem::path& file);

/// As CheckFolderOf; also where the file is edited and `force` is not set.
void CheckOut(const std::filesystem::path& file, bool force);

/// Writes a text of TOML, and a comment below it that lets IsEdited see what becomes of it. An edited file that is
/// there keeps a second name, with its time, which is printed. Throws as WriteFileAtomically.
void WriteCalibration(const std::filesystem::path& file, const std::string& text);

/// The time, as "2024-05-01T12:00:00Z".
std::string NowInUtc();

}  // namespace chequer
