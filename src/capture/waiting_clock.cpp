#include "capture/waiting_clock.h"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "core/clock.h"

namespace chequer {
namespace {

class SystemClock final : public WaitingClock {
 public:
  MonotonicTime Now() const override { return clock_.monotonic(); }
  UtcTime NowUtc() const override { return clock_.utc(); }

  bool WaitUntil(MonotonicTime time) override {
    std::unique_lock lock(mutex_);
    woken_.wait_until(lock, time, [&] { return interrupted_; });
    return !std::exchange(interrupted_, false);
  }

  void Interrupt() override {
    {
      const std::lock_guard lock(mutex_);
      interrupted_ = true;
    }
    woken_.notify_all();
  }

  bool IsInterrupted() const override {
    const std::lock_guard lock(mutex_);
    return interrupted_;
  }

 private:
  Clock clock_ = Clock::System();
  mutable std::mutex mutex_;
  std::condition_variable woken_;
  bool interrupted_ = false;
};

}  // namespace

std::unique_ptr<WaitingClock> MakeSystemClock() { return std::make_unique<SystemClock>(); }

}  // namespace chequer
