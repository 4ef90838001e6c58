#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/unique_fd.h"

namespace chequer {

/// What becomes of a log that is there.
enum class EarlierLog : std::uint8_t {
  kSetAside,  ///< it is renamed, with its time in its name
  kAppend,    ///< it grows; one that is damaged, or no log, is renamed all the same
};

/// Writes an LCM log, message by message: each is in the file whole or not at all, also where a disk is full. Devices
/// and pipes are written into. One thread, and one writer a file on this host.
class LcmLogWriter {
 public:
  /// Throws std::runtime_error naming the file and the cause; also where another writer has it.
  LcmLogWriter(const std::filesystem::path& path, EarlierLog earlier);

  /// Empty, or why the message is not in the log.
  std::string Write(UtcTime time, const std::string& channel, std::span<const std::uint8_t> data);

  /// What the earlier log is called now; empty where there was none, or it is appended to.
  const std::filesystem::path& set_aside() const { return set_aside_; }

 private:
  bool Open(EarlierLog earlier);
  int WriteAll(std::span<const std::uint8_t> bytes);

  std::filesystem::path path_;
  std::filesystem::path set_aside_;
  UniqueFd file_;
  bool is_ordinary_ = true;
  std::int64_t end_ = 0;  ///< of the last whole event, bytes
  std::int64_t count_ = 0;
  std::vector<std::uint8_t> event_;
};

}  // namespace chequer
