#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "daemon/progress.h"

namespace chequer {

/// Feeds the service manager's watchdog while the pipeline makes progress, and only then; says in the log what hangs.
/// One thread.
class Watchdog {
 public:
  /// @param watchdog how often the service manager wants to hear, if at all.
  explicit Watchdog(std::optional<std::chrono::microseconds> watchdog);

  /// How often Look wants to be called: some times in the watchdog's period.
  std::chrono::milliseconds period() const { return period_; }
  /// What counts as a hang: less than the watchdog's period, so that it is found out before the period ends.
  const ProgressLimits& limits() const { return limits_; }

  /// @param stuck Progress::Stuck. @param feed called where all is well.
  void Look(const std::string& stuck, const std::function<void()>& feed);

 private:
  std::chrono::milliseconds period_;
  ProgressLimits limits_;
  bool was_stuck_ = false;
};

}  // namespace chequer
