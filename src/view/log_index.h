#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "publish/lcm_log_events.h"

namespace chequer {

/// Where in a log which time lies: one place each quarter of a second, so that any moment is found at once.
class LogIndex {
 public:
  /// Reads through the log once. Throws std::runtime_error naming the file where it cannot be read or holds no message.
  explicit LogIndex(const std::filesystem::path& path);

  UtcTime first() const { return first_; }
  UtcTime last() const { return last_; }
  /// A place at or before that time: where reading begins.
  std::int64_t PlaceBefore(UtcTime time) const;
  const std::filesystem::path& path() const { return path_; }

 private:
  struct Entry {
    UtcTime time{};
    std::int64_t place = 0;
  };
  std::filesystem::path path_;
  std::vector<Entry> entries_;
  UtcTime first_{}, last_{};
};

}  // namespace chequer
