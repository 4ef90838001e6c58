#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "chequer/detector.h"
#include "core/toml_reader.h"

namespace chequer {

/// Reads [print] of a configuration; config/chequerd.toml says what its keys mean. Throws std::runtime_error naming
/// file, line, key, value and what would be right.
PrintTolerance ReadPrintTolerance(TomlTable table);

/// The tolerance of "office", "none" or "SCALE,REGISTER" such as "0.0025,0.03mm"; nothing for anything else.
std::optional<PrintTolerance> ParsePrintTolerance(std::string_view text);

/// What ParsePrintTolerance knows, for messages.
inline constexpr std::string_view kPrintToleranceForms = "office, none, or SCALE,REGISTER such as 0.0025,0.03mm";

}  // namespace chequer
