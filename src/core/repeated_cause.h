#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "chequer/frame.h"

namespace chequer {

/// Decides which of many equal complaints reach the log: the first of a cause, then a reminder with a count after a
/// minute, two, four … up to an hour. One thread.
class RepeatedCause {
 public:
  /// What to log, or nothing to log (empty).
  /// @param cause tells kinds of trouble apart; another one than the last is logged at once.
  /// @param detail of this occurrence, put behind the cause; may be empty.
  std::string Occurred(std::string_view cause, std::string_view detail, MonotonicTime now);

  /// The trouble has passed; how often it occurred, 0 if it did not since the last call.
  std::uint64_t Ended();

 private:
  std::string cause_;
  std::uint64_t occurrences_ = 0;  ///< of cause_
  std::uint64_t unlogged_ = 0;     ///< of them, since the last that was logged
  MonotonicTime logged_at_{};
  std::chrono::seconds reminder_{};
};

}  // namespace chequer
