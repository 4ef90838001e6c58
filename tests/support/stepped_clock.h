#pragma once

#include <atomic>
#include <chrono>

#include "core/clock.h"

namespace chequer::test {

/// A clock for the daemon and the publisher that stands until the test moves it. Any thread.
class SteppedClock {
 public:
  Clock clock() {
    return {[this] { return UtcTime(std::chrono::seconds(1'700'000'000) + std::chrono::microseconds(now_.load())); },
            [this] { return MonotonicTime(std::chrono::microseconds(now_.load())); }};
  }
  void Advance(std::chrono::microseconds time) { now_ += time.count(); }

 private:
  std::atomic<std::int64_t> now_{1'000'000'000};
};

}  // namespace chequer::test
