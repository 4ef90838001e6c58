#include "daemon/watchdog.h"

#include <algorithm>
#include <utility>

#include "daemon/log_event.h"

namespace chequer {

using std::chrono::microseconds;
using std::chrono::milliseconds;

Watchdog::Watchdog(std::optional<microseconds> watchdog) : period_(1000) {
  if (!watchdog) return;
  period_ = std::clamp(std::chrono::duration_cast<milliseconds>(*watchdog / 4), milliseconds(1), milliseconds(1000));
  limits_.work = std::min<microseconds>(limits_.work, *watchdog / 2);
}

void Watchdog::Look(const std::string& stuck, const std::function<void()>& feed) {
  if (stuck.empty()) {
    if (std::exchange(was_stuck_, false)) LogEvent(LogLevel::kWarning, "progress", "progress is made again");
    feed();
    return;
  }
  if (!std::exchange(was_stuck_, true))
    LogEvent(LogLevel::kError, "stuck", stuck + "; the watchdog is not fed until there is progress");
}

}  // namespace chequer
