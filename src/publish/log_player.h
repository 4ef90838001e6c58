#pragma once

#include <chrono>
#include <optional>

#include "core/clock.h"
#include "publish/lcm_log_events.h"
#include "publish/lcm_url.h"

namespace chequer {

/// Gives the messages of a log when they are due, as LCM's file:// does: at the pace of the log times `speed` of the
/// URL (1 where it has none; 0: as fast as they are taken), beginning at `start_timestamp`. One thread.
class LogPlayer {
 public:
  /// Throws std::runtime_error naming the file where it cannot be read.
  explicit LogPlayer(const LcmUrl& url);

  /// The next message, if it is due within that time; waits for it. Nothing otherwise, and at the end.
  std::optional<LogEvent> Next(std::chrono::milliseconds timeout);
  /// Whether all messages were given.
  bool is_over() const { return is_over_; }
  /// Whether some could not be, as the log is damaged. Known when it is over.
  bool damaged() const { return events_.damaged(); }

 private:
  void Fetch();

  LogEventReader events_;
  double speed_ = 1;
  UtcTime start_{};
  std::optional<LogEvent> next_;
  std::optional<UtcTime> first_logged_;
  std::chrono::steady_clock::time_point began_{};
  bool is_over_ = false;
};

}  // namespace chequer
