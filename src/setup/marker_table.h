#pragma once

#include <filesystem>

#include "chequer/detector.h"
#include "core/toml_reader.h"

namespace chequer {

/// Reads one [[marker]] of a configuration; config/chequerd.toml says what its keys mean. Throws std::runtime_error
/// naming file, line, key, value and what would be right.
/// @param base the folder that paths are relative to.
/// @param need_side whether poses are wanted, which need the side; else a side that is left out is 0.
MarkerFamily ReadMarkerFamily(TomlTable& table, const std::filesystem::path& base, bool need_side);

}  // namespace chequer
