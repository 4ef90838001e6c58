#pragma once

#include <filesystem>

namespace chequer {

/// Renames a file so that another can take its name: "poses.lcm" that was last written to at noon becomes
/// "poses-20240501T120000Z.lcm" (UTC), or "poses-20240501T120000Z-2.lcm" where there is such a file. Never replaces a
/// file. Returns the new path. Throws std::runtime_error naming the file and the cause. @pre the path is no link.
std::filesystem::path SetAside(const std::filesystem::path& path);

/// Gives a file such a name besides its own, so that it stays when another takes its place (core/output_file.h).
/// Returns the second path. Throws as SetAside.
std::filesystem::path KeepAside(const std::filesystem::path& path);

}  // namespace chequer
