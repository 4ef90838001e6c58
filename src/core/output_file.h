#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/file.h"
#include "core/unique_fd.h"

namespace chequer {

/// Where a path leads through symbolic links, also where the last link leads to a file that is not there yet. Throws
/// std::runtime_error where links lead in a circle.
std::filesystem::path ThroughLinks(const std::filesystem::path& path);

/// Why a file cannot be written at that place, as far as can be told before; empty where it can.
std::string WhyNotWritable(const std::filesystem::path& path);

/// What becomes of a write into a pipe or a terminal whose reader is slow. A daemon must not wait for it.
enum class SlowReader : std::uint8_t { kWaitedFor, kRefused };

/// A file that is being written. An ordinary file appears, whole, in the place of the one before when it is finished;
/// without that nothing has changed. It keeps the mode of the one before, and its owner where the system allows that;
/// symbolic links stay and lead to it. Devices, pipes and open files of a process (/dev/stdout) are written into, as
/// nothing can take their place; a pipe that nobody has open for reading is refused at once. Where a reader is slow,
/// writing waits for it, or fails, as asked for.
class OutputFile {
 public:
  /// Throws std::runtime_error naming the file and the cause: no such folder, no permission, a folder.
  explicit OutputFile(const std::filesystem::path& path, SlowReader slow_reader = SlowReader::kWaitedFor);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Throws std::runtime_error naming the file and the cause, such as a full disk.
  void Write(std::span<const std::uint8_t> bytes);
  void Write(std::string_view text);

  /// Puts it in its place. Throws as Write. @param durability of the file and its name.
  void Finish(Durability durability = Durability::kSynced);

 private:
  void Flush();
  void WriteThrough(std::span<const std::uint8_t> bytes);
  [[noreturn]] void Fail(int error) const;
  [[noreturn]] void FailAs(const char* why) const;

  std::filesystem::path path_;     ///< as given, for messages
  std::filesystem::path target_;   ///< what it leads to
  std::filesystem::path partial_;  ///< beside the target until finished; empty where something is written into
  UniqueFd fd_;
  std::array<std::uint8_t, 65536> buffer_;
  std::size_t buffered_ = 0;
};

/// As WriteFileAtomically, and never waits: where a pipe's reader has not read what was written before, that is an
/// error.
void WriteWithoutWaiting(const std::filesystem::path& path, std::string_view text, Durability durability);

}  // namespace chequer
