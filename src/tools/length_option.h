#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

namespace chequer {

/// Metres of "60mm", "6cm", "0.06m" or "0.06" (metres). Throws CLI::ValidationError naming the option where it is
/// anything else, or not above 0.
double ParseLengthOption(const char* option, const std::string& text);

/// Adds an option that is a length, in units of `unit_m` metres: a bare number is in that unit, and so is what `value`
/// gets. `value` must outlive the parsing.
CLI::Option* AddLengthOption(CLI::App& command, const char* name, double& value, const std::string& help,
                             double unit_m = 1);
CLI::Option* AddLengthOption(CLI::App& command, const char* name, std::optional<double>& value, const std::string& help,
                             double unit_m = 1);

}  // namespace chequer
