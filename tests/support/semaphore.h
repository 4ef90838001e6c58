#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace chequer::test {

/// Counts what may be taken, for threads that wait for each other in tests. In place of std::counting_semaphore: where one
/// waits with a timeout, that of libstdc++ 12 misses some releases (one in a hundred on a busy machine).
class Semaphore {
 public:
  explicit Semaphore(int count) : count_(count) {}

  void release(int more = 1) {
    // Notified under the lock: who was waited for may destroy this at once.
    const std::lock_guard lock(mutex_);
    count_ += more;
    more == 1 ? released_.notify_one() : released_.notify_all();
  }
  /// False when the time is over.
  template <class Duration>
  bool try_acquire_for(const Duration& timeout) {
    std::unique_lock lock(mutex_);
    if (!released_.wait_for(lock, timeout, [this] { return count_ > 0; })) return false;
    --count_;
    return true;
  }

 private:
  std::mutex mutex_;
  std::condition_variable released_;
  int count_;
};

}  // namespace chequer::test
