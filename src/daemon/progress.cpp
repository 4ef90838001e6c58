#include "daemon/progress.h"

#include <spdlog/fmt/fmt.h>

#include <utility>

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

Progress::Progress(int workers, PiecesDone pieces)
    : pieces_(std::move(pieces)),
      worker_count_(workers),
      workers_(std::make_unique<Worker[]>(static_cast<std::size_t>(workers))) {}

int Progress::busy_workers(MonotonicTime now) const {
  int busy = 0;
  for (int i = 0; i < worker_count_; ++i)
    busy += workers_[static_cast<std::size_t>(i)].activity.Lasting(now).has_value() ? 1 : 0;
  return busy;
}

std::string Progress::UnderWay(MonotonicTime now) const {
  std::string list;
  const auto name = [&](const Activity& activity, const std::string& what) {
    if (activity.Lasting(now)) list.append(list.empty() ? "" : ", ").append(what);
  };
  for (int i = 0; i < worker_count_; ++i)
    name(workers_[static_cast<std::size_t>(i)].activity, "worker " + std::to_string(i) + " is at a frame");
  name(capture.opening, "the camera is being opened");
  name(capture.capturing, "the camera's thread has not come back");
  name(sending, "LCM is being handed a message");
  return list;
}

void Progress::NoticePieces(MonotonicTime now) {
  if (!pieces_) return;
  for (int i = 0; i < worker_count_; ++i) {
    Worker& worker = workers_[static_cast<std::size_t>(i)];
    const std::uint64_t done = pieces_(i);
    if (std::exchange(worker.pieces_seen, done) == done) continue;
    worker.activity.Renew(now);
    frames.Renew(now);
  }
}

std::string Progress::Stuck(MonotonicTime now, const ProgressLimits& limits) {
  NoticePieces(now);
  const auto complain = [&](const std::string& who, const Activity& activity) {
    return who + " " + Seconds(activity.Lasting(now).value_or(microseconds(0)));
  };
  // The cause first: when a worker hangs, no frame comes out either.
  for (int i = 0; i < worker_count_; ++i) {
    const Activity& worker = workers_[static_cast<std::size_t>(i)].activity;
    if (IsTooLong(worker, now, limits.work))
      return complain("worker " + std::to_string(i) + " has made no progress with a frame for", worker);
  }
  if (IsTooLong(capture.capturing, now, limits.work))
    return complain("the camera's thread has not come back for", capture.capturing);
  if (IsTooLong(capture.opening, now, limits.opening)) return complain("opening the camera has taken", capture.opening);
  if (IsTooLong(sending, now, limits.work)) return complain("handing one message to LCM has taken", sending);
  if (IsTooLong(publishing, now, limits.work)) return complain("publishing one message has taken", publishing);
  if (IsTooLong(frames, now, limits.work)) return complain("frames come and none has been published for", frames);
  return {};
}

}  // namespace chequer
