#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "chequer/frame.h"
#include "core/unique_fd.h"

// LCM's log format, without LCM: its own reader adds 1 to a length from the file and writes beyond what it took for it,
// and its own writer leaves half a message where a disk is full. An event is the word 0xEDA1DA01, its number (64 bits),
// its time (64 bits, microseconds of UTC), the lengths of channel and data (32 bits each), all big-endian; then both.

namespace chequer {

inline constexpr std::uint32_t kLogSyncWord = 0xEDA1DA01;

/// One message as a log holds it, of whatever type.
struct LogEvent {
  UtcTime logged{};
  std::string channel;
  std::vector<std::uint8_t> data;
};

/// The bytes of an event. @param number of the event, counted from 0 in its log.
void EncodeLogEvent(std::int64_t number, UtcTime logged, const std::string& channel, std::span<const std::uint8_t> data,
                    std::vector<std::uint8_t>& bytes);

/// Reads the events of a log. Where the log is damaged it goes on at the next whole event.
class LogEventReader {
 public:
  /// Throws std::runtime_error naming the file where it cannot be opened, or is no ordinary file.
  explicit LogEventReader(const std::filesystem::path& path);
  /// @param file an ordinary file, opened for reading.
  explicit LogEventReader(UniqueFd file);

  /// The next whole event; nothing at the end of the log.
  std::optional<LogEvent> Next();

  /// Where the next event is looked for, bytes from the log's beginning; and to go on elsewhere. Damage that was found
  /// stays found.
  std::int64_t place() const { return offset_; }
  void Seek(std::int64_t place) { offset_ = place; }

  /// Events so far.
  std::int64_t count() const { return count_; }
  /// Whether bytes were passed over that are no whole event: the log is cut off or damaged there.
  bool damaged() const { return damaged_; }

 private:
  struct Header {
    std::uint32_t sync = 0;
    std::int64_t time_us = 0;
    std::uint32_t channel_bytes = 0;
    std::uint32_t data_bytes = 0;
  };
  bool ReadHeader(Header& header);
  /// Whether there were so many bytes at that place.
  bool ReadAt(std::int64_t offset, std::span<std::uint8_t> bytes);
  void SkipToNextSyncWord();

  UniqueFd file_;
  std::int64_t offset_ = 0;  ///< of the next event, bytes
  std::vector<std::uint8_t> window_;
  std::int64_t window_offset_ = 0;
  std::int64_t count_ = 0;
  bool damaged_ = false;
};

}  // namespace chequer
