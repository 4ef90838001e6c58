#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace chequer {

/// `chequer calibrate lens`.
void AddCalibrateLensCommand(CLI::App& calibrate);
/// `chequer calibrate world`.
void AddCalibrateWorldCommand(CLI::App& calibrate);

/// The time, as "2024-05-01T12:00:00Z".
std::string NowInUtc();

}  // namespace chequer
