#include "daemon/progress.h"

#include <spdlog/fmt/fmt.h>

namespace chequer {
namespace {

using std::chrono::microseconds;

std::string Seconds(microseconds time) { return fmt::format("{:.1f} s", static_cast<double>(time.count()) / 1e6); }

bool IsTooLong(const Activity& activity, MonotonicTime now, microseconds limit) {
  const auto lasting = activity.Lasting(now);
  return lasting && *lasting > limit;
}

}  // namespace

std::optional<microseconds> Activity::Lasting(MonotonicTime now) const {
  const std::int64_t since = since_us_;
  if (since == kIdle) return std::nullopt;
  return now.time_since_epoch() - microseconds(since);
}

Progress::Progress(int workers)
    : worker_count_(workers), workers_(std::make_unique<Activity[]>(static_cast<std::size_t>(workers))) {}

std::string Progress::Stuck(MonotonicTime now, const ProgressLimits& limits) const {
  const auto complain = [&](const std::string& who, const Activity& activity) {
    return who + " " + Seconds(activity.Lasting(now).value_or(microseconds(0)));
  };
  // The cause first: when a worker hangs, no frame comes out either.
  for (int i = 0; i < worker_count_; ++i) {
    const Activity& worker = workers_[static_cast<std::size_t>(i)];
    if (IsTooLong(worker, now, limits.work))
      return complain("worker " + std::to_string(i) + " has been at one frame for", worker);
  }
  if (IsTooLong(capture.capturing, now, limits.work))
    return complain("the camera's thread has not come back for", capture.capturing);
  if (IsTooLong(capture.opening, now, limits.opening)) return complain("opening the camera has taken", capture.opening);
  if (IsTooLong(publishing, now, limits.work)) return complain("publishing one message has taken", publishing);
  if (IsTooLong(frames, now, limits.work)) return complain("frames come and none has been published for", frames);
  return {};
}

}  // namespace chequer
