#pragma once

#include <utility>

#include "capture/waiting_clock.h"

namespace chequer::test {

/// A clock in which waiting takes no time: it jumps to what is waited for. One thread.
class ManualClock final : public WaitingClock {
 public:
  MonotonicTime Now() const override { return now_; }
  UtcTime NowUtc() const override { return utc_at_zero_ + now_.time_since_epoch(); }

  bool WaitUntil(MonotonicTime time) override {
    if (std::exchange(interrupted_, false)) return false;
    if (time > now_) now_ = time;
    return true;
  }
  void Interrupt() override { interrupted_ = true; }
  bool IsInterrupted() const override { return interrupted_; }

  void Advance(std::chrono::microseconds by) { now_ += by; }

 private:
  MonotonicTime now_{std::chrono::seconds(1000)};
  UtcTime utc_at_zero_{std::chrono::seconds(1'700'000'000)};
  bool interrupted_ = false;
};

}  // namespace chequer::test
