#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/unique_fd.h"

namespace chequer {

/// The longest text that is read whole: truth of a long recording, a run's poses. A limit, so that a file that was
/// named by mistake does not fill the memory.
inline constexpr std::size_t kMaxTextBytes = std::size_t{1} << 30;

/// Opens a file that a configuration or a command line names, for reading. Every reader goes through here, because it
/// never waits: what is no regular file (a pipe, a device, a socket) may have nothing to say for ever. Throws
/// std::runtime_error naming the file and the cause: missing, not permitted, a folder, a pipe and so on.
UniqueFd OpenForReading(const std::filesystem::path& path);

/// The bytes of a file, at most `max_bytes` of them. Throws std::runtime_error naming the file and the cause: missing,
/// not permitted, no regular file, or longer than that.
std::string ReadFile(const std::filesystem::path& path, std::size_t max_bytes);

/// Whether a file survives a loss of power as soon as it is written. That costs milliseconds of the disk, so files of a
/// stream are left to the system, and those that are made anew each second.
enum class Durability : std::uint8_t { kSynced, kUnsynced };

/// Writes a whole file; core/output_file.h says what becomes of one that is there, of links, devices and pipes. Throws
/// std::runtime_error naming the file and the cause (no space, no permission, …); nothing is changed then.
void WriteFileAtomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes,
                         Durability durability = Durability::kSynced);
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text,
                         Durability durability = Durability::kSynced);

/// Makes all files last that were written into a folder, with one call for all of them. Throws std::runtime_error
/// naming the folder and the cause.
void SyncFolder(const std::filesystem::path& folder);

}  // namespace chequer
