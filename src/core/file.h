#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace chequer {

/// The bytes of a file, at most `max_bytes` of them. Throws std::runtime_error naming the file and the cause: missing,
/// not permitted, a folder, or longer than that.
std::string ReadFile(const std::filesystem::path& path, std::size_t max_bytes);

/// Writes a file so that it is there whole or not at all: into a neighbour first, then renamed. Throws
/// std::runtime_error naming the file and the cause (no space, no permission, …); nothing is left behind then.
void WriteFileAtomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

}  // namespace chequer
