#include "publish/lcm_log_events.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "core/file.h"

namespace chequer {
namespace {

constexpr std::size_t kEventHeaderBytes = 28;
/// As LCM's own reader; LCM carries channels of at most 63 bytes.
constexpr std::uint32_t kMaxChannelBytes = 1000;
/// LCM's own limit of a message.
constexpr std::uint32_t kMaxDataBytes = 1u << 28;
constexpr std::size_t kWindowBytes = 65536;

template <typename Number>
void PutBigEndian(Number value, std::vector<std::uint8_t>& bytes) {
  for (int shift = static_cast<int>(8 * sizeof value) - 8; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> shift));
}

template <typename Number>
Number BigEndian(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i) value = value << 8 | bytes[i];
  return static_cast<Number>(value);
}

}  // namespace

void EncodeLogEvent(std::int64_t number, UtcTime logged, const std::string& channel, std::span<const std::uint8_t> data,
                    std::vector<std::uint8_t>& bytes) {
  bytes.clear();
  PutBigEndian(kLogSyncWord, bytes);
  PutBigEndian(number, bytes);
  PutBigEndian(std::int64_t{logged.time_since_epoch().count()}, bytes);
  PutBigEndian(static_cast<std::uint32_t>(channel.size()), bytes);
  PutBigEndian(static_cast<std::uint32_t>(data.size()), bytes);
  bytes.insert(bytes.end(), channel.begin(), channel.end());
  bytes.insert(bytes.end(), data.begin(), data.end());
}

LogEventReader::LogEventReader(const std::filesystem::path& path) : LogEventReader(OpenForReading(path)) {}

LogEventReader::LogEventReader(UniqueFd file) : file_(std::move(file)) {}

bool LogEventReader::ReadAt(std::int64_t offset, std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const std::int64_t in_window = offset - window_offset_;
    if (in_window >= 0 && in_window < std::ssize(window_)) {
      const std::size_t count = std::min(bytes.size(), window_.size() - static_cast<std::size_t>(in_window));
      std::memcpy(bytes.data(), window_.data() + in_window, count);
      bytes = bytes.subspan(count);
      offset += static_cast<std::int64_t>(count);
      continue;
    }
    window_.resize(kWindowBytes);
    const ssize_t count = ::pread(file_.get(), window_.data(), window_.size(), offset);
    window_.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    window_offset_ = offset;
    if (count <= 0) return false;
  }
  return true;
}

bool LogEventReader::ReadHeader(Header& header) {
  std::array<std::uint8_t, kEventHeaderBytes> bytes{};
  if (!ReadAt(offset_, bytes)) return false;
  header.sync = BigEndian<std::uint32_t>(&bytes[0]);
  header.time_us = BigEndian<std::int64_t>(&bytes[12]);
  header.channel_bytes = BigEndian<std::uint32_t>(&bytes[20]);
  header.data_bytes = BigEndian<std::uint32_t>(&bytes[24]);
  return true;
}

void LogEventReader::SkipToNextSyncWord() {
  damaged_ = true;
  std::uint32_t word = 0;
  std::uint8_t byte = 0;
  for (++offset_; ReadAt(offset_, {&byte, 1}); ++offset_) {
    word = word << 8 | byte;
    if (word != kLogSyncWord) continue;
    offset_ -= 3;
    return;
  }
}

std::optional<LogEvent> LogEventReader::Next() {
  while (true) {
    struct stat status {};
    if (::fstat(file_.get(), &status) != 0) return std::nullopt;
    const std::int64_t size = status.st_size;
    if (offset_ >= size) return std::nullopt;
    Header header;
    const bool is_header = ReadHeader(header) && header.sync == kLogSyncWord &&
                           header.channel_bytes <= kMaxChannelBytes && header.data_bytes <= kMaxDataBytes;
    const std::int64_t body = offset_ + static_cast<std::int64_t>(kEventHeaderBytes);
    const std::int64_t end = body + header.channel_bytes + header.data_bytes;
    // No memory is taken for what the file does not hold.
    if (!is_header || end > size) {
      SkipToNextSyncWord();
      continue;
    }
    LogEvent event;
    event.logged = UtcTime(std::chrono::microseconds(header.time_us));
    std::vector<std::uint8_t> channel(header.channel_bytes);
    event.data.resize(header.data_bytes);
    if (!ReadAt(body, channel) || !ReadAt(body + header.channel_bytes, event.data)) {
      SkipToNextSyncWord();
      continue;
    }
    event.channel.assign(channel.begin(), channel.end());
    offset_ = end;
    ++count_;
    return event;
  }
}

}  // namespace chequer
