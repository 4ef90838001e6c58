#pragma once

#include <algorithm>
#include <chrono>
#include <string>

#include "chequer/frame.h"

namespace chequer {

/// Tells when a camera that should deliver has fallen silent: no frame for three periods, at least half a second, and
/// after opening, when exposure and gain settle and some cameras take their time, at least three seconds. One thread.
class SilenceWatch {
 public:
  static constexpr std::chrono::milliseconds kShortest{500};
  static constexpr std::chrono::milliseconds kShortestAtFirst{3000};  // slow webcams take up to two

  /// The camera was opened. @param period of its frames; zero: it delivers when triggered from outside, and is never
  /// called silent.
  void Opened(std::chrono::microseconds period, MonotonicTime now) {
    period_ = period;
    since_ = now;
    had_frame_ = false;
  }

  /// A frame came, or none could come because every buffer was in use.
  void Alive(MonotonicTime now, bool had_frame = true) {
    since_ = now;
    had_frame_ |= had_frame;
  }

  /// How long to wait until it counts as silent; zero or less: it does. The longest time where it never does.
  std::chrono::microseconds Left(MonotonicTime now) const {
    if (period_.count() <= 0) return std::chrono::microseconds::max();
    return Limit() - (now - since_);
  }
  bool IsSilent(MonotonicTime now) const { return Left(now).count() <= 0; }

  /// "no frame for 0.5 s".
  std::string Message(MonotonicTime now) const {
    const auto tenths = std::chrono::duration_cast<std::chrono::milliseconds>(now - since_).count() / 100;
    return "no frame for " + std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " s";
  }

 private:
  std::chrono::microseconds Limit() const {
    return std::max<std::chrono::microseconds>(3 * period_, had_frame_ ? kShortest : kShortestAtFirst);
  }

  std::chrono::microseconds period_{};
  MonotonicTime since_{};
  bool had_frame_ = false;
};

}  // namespace chequer
