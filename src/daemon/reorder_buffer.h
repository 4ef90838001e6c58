#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "chequer/check.h"

namespace chequer {

/// Brings what several workers finish in any order back into the order of their tickets (0, 1, 2 …, each once). Holds
/// at most `capacity` items; a worker that is further ahead waits, so that one slow frame cannot pile up the others.
template <typename Item>
class ReorderBuffer {
 public:
  explicit ReorderBuffer(std::uint64_t capacity) : capacity_(capacity) {
    CHEQUER_CHECK(capacity > 0, "a buffer must hold something");
  }

  /// Any thread. The holder of the ticket that is next never waits.
  void Push(std::uint64_t ticket, Item item) {
    {
      std::unique_lock lock(mutex_);
      popped_.wait(lock, [&] { return aborted_ || ticket < next_ + capacity_; });
      if (aborted_) return;
      CHEQUER_CHECK(ticket >= next_, "a ticket was used twice");
      items_.emplace(ticket, std::move(item));
    }
    pushed_.notify_one();
  }

  /// The item whose turn it is; waits for it, at most `timeout`. Nothing when the time is over or the buffer is done.
  std::optional<Item> Pop(std::chrono::microseconds timeout) {
    std::optional<Item> item;
    {
      std::unique_lock lock(mutex_);
      pushed_.wait_for(lock, timeout, [this] { return closed_ || aborted_ || HasNext(); });
      if (aborted_ || !HasNext()) return std::nullopt;
      item.emplace(std::move(items_.begin()->second));
      items_.erase(items_.begin());
      ++next_;
    }
    popped_.notify_all();
    return item;
  }

  /// No ticket is still to come.
  void Close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    pushed_.notify_all();
  }

  /// Gives up: a ticket will never come. Whoever waits is released, what is held is thrown away.
  void Abort() {
    {
      const std::lock_guard lock(mutex_);
      aborted_ = true;
      items_.clear();
    }
    pushed_.notify_all();
    popped_.notify_all();
  }

  /// Whether nothing will come any more.
  bool IsDone() const {
    const std::lock_guard lock(mutex_);
    return aborted_ || (closed_ && items_.empty());
  }

 private:
  bool HasNext() const { return !items_.empty() && items_.begin()->first == next_; }

  const std::uint64_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable pushed_;
  std::condition_variable popped_;
  std::map<std::uint64_t, Item> items_;
  std::uint64_t next_ = 0;
  bool closed_ = false;
  bool aborted_ = false;
};

}  // namespace chequer
