#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "publish/wire.h"

namespace chequer {

/// One message of a log.
struct LogRecord {
  UtcTime logged{};  ///< when the logger received it
  std::string channel;
  ReceivedMessage message;
};

/// Reads our messages out of a file written by lcm-logger or by a publisher's file:// URL.
class LcmLogReader {
 public:
  /// Throws std::runtime_error naming the file where it cannot be opened.
  explicit LcmLogReader(const std::filesystem::path& path);
  ~LcmLogReader();

  /// The next message of ours; nothing at the end of the log.
  std::optional<LogRecord> Next();

  /// Messages of other types or versions that Next passed over.
  std::uint64_t skipped() const;
  /// Whether the log is cut off, or damaged at a place that Next passed over. Known when Next gave nothing.
  bool damaged() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer
