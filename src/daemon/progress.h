#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "chequer/frame.h"

namespace chequer {

/// Whether a part of the pipeline is at work, and since when. Waiting for something known (a frame that may come, a
/// turn, the time to open a camera again) is no work. One thread begins and ends, any may ask.
class Activity {
 public:
  void Begin(MonotonicTime now) { since_us_ = now.time_since_epoch().count(); }
  /// As Begin, but an earlier beginning stands. Any thread.
  void BeginUnlessBegun(MonotonicTime now) {
    std::int64_t idle = kIdle;
    since_us_.compare_exchange_strong(idle, now.time_since_epoch().count());
  }
  /// As if it began now, where it has begun: there is progress. Any thread.
  void Renew(MonotonicTime now) {
    std::int64_t since = since_us_;
    if (since != kIdle) since_us_.compare_exchange_strong(since, now.time_since_epoch().count());
  }
  void End() { since_us_ = kIdle; }

  /// How long it has lasted; nothing while it is idle.
  std::optional<std::chrono::microseconds> Lasting(MonotonicTime now) const;

 private:
  static constexpr std::int64_t kIdle = -1;
  std::atomic<std::int64_t> since_us_{kIdle};
};

/// What the capture thread is at.
struct CaptureActivity {
  Activity opening;    ///< opening the source, which may take a camera's firmware or a large recording long
  Activity capturing;  ///< anything else but waiting: asking for a frame returns within a fraction of a second
};

/// How long parts may take without a sign of progress.
struct ProgressLimits {
  std::chrono::microseconds work = std::chrono::seconds(5);
  std::chrono::microseconds opening = std::chrono::seconds(120);
};

/// Pieces of work that a worker has done in all, which show progress within a frame. Any thread.
using PiecesDone = std::function<std::uint64_t(int worker)>;

/// What every part of a pipeline is at: tells a pipeline that works or waits from one that hangs. A frame that takes
/// long is no hang while pieces of it are done.
class Progress {
 public:
  /// @param pieces may be empty: then whole frames alone show progress.
  explicit Progress(int workers, PiecesDone pieces = {});

  CaptureActivity capture;
  Activity publishing;  ///< making messages of frames
  Activity sending;     ///< handing them to LCM
  /// From the first frame that was captured after the last one published, until the next is published.
  Activity frames;
  Activity& worker(int index) { return workers_[static_cast<std::size_t>(index)].activity; }
  /// How many workers are at a frame.
  int busy_workers(MonotonicTime now) const;

  /// What is at work now, such as "worker 0 is at a frame"; empty where nothing is. Any thread.
  std::string UnderWay(MonotonicTime now) const;

  /// Empty while every part makes progress or waits for something known, else which does not and since when. One
  /// thread.
  std::string Stuck(MonotonicTime now, const ProgressLimits& limits);

 private:
  struct Worker {
    Activity activity;
    std::uint64_t pieces_seen = 0;
  };
  void NoticePieces(MonotonicTime now);

  PiecesDone pieces_;
  int worker_count_;
  std::unique_ptr<Worker[]> workers_;
};

}  // namespace chequer
