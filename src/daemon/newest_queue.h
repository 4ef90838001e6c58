#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace chequer {

/// What became of the items that came to a queue. All that came were taken, superseded, or discarded, or one waits.
struct QueueCounts {
  std::uint64_t came = 0;
  std::uint64_t superseded = 0;  ///< replaced by a newer one before they were taken
  std::uint64_t discarded = 0;   ///< thrown away when it was closed, or came after that
  int waiting = 0;               ///< 0 or 1
};

/// A queue of one in which what is newer replaces what waits: whoever takes never gets a stale item, and the delay is
/// bounded by construction. One thread puts, any number take.
template <typename Item>
class NewestQueue {
 public:
  struct Taken {
    Item item;
    std::uint64_t ticket = 0;      ///< counts what was taken, in the order it was put, from 0
    std::uint64_t superseded = 0;  ///< items that were replaced before this one was taken, since the start
  };

  /// Puts an item, in the place of one that waits. False after Close; the item is gone then.
  bool Put(Item item) {
    std::optional<Item> old(std::move(item));  // dies after the lock is released: it may give a buffer back
    {
      const std::lock_guard lock(mutex_);
      if (!Came()) return false;
      std::swap(old, waiting_);
      if (old) ++counts_.superseded;
    }
    put_.notify_one();
    return true;
  }

  /// Puts an item when none waits any more. False after Close; the item is gone then.
  bool PutWhenFree(Item item) {
    {
      std::unique_lock lock(mutex_);
      taken_.wait(lock, [this] { return closed_ || !waiting_; });
      if (!Came()) return false;
      waiting_.emplace(std::move(item));
    }
    put_.notify_one();
    return true;
  }

  /// Waits for an item. Nothing once the queue is closed and empty.
  std::optional<Taken> Take() {
    std::optional<Taken> taken;
    {
      std::unique_lock lock(mutex_);
      put_.wait(lock, [this] { return closed_ || waiting_; });
      if (!waiting_) return std::nullopt;
      taken.emplace(Taken{std::move(*waiting_), next_ticket_++, counts_.superseded});
      waiting_.reset();
    }
    taken_.notify_one();
    return taken;
  }

  /// Nothing more will be put; what waits can still be taken.
  void Close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    put_.notify_all();
    taken_.notify_all();
  }

  /// Closes, and throws away what waits.
  void CloseAndDiscard() {
    std::optional<Item> discarded;  // dies after the lock is released
    {
      const std::lock_guard lock(mutex_);
      std::swap(discarded, waiting_);
      if (discarded) ++counts_.discarded;
      closed_ = true;
    }
    put_.notify_all();
    taken_.notify_all();
  }

  /// All of one moment.
  QueueCounts counts() const {
    const std::lock_guard lock(mutex_);
    QueueCounts counts = counts_;
    counts.waiting = waiting_ ? 1 : 0;
    return counts;
  }

 private:
  /// Counts an item that has come; false where it came too late. @pre locked
  bool Came() {
    ++counts_.came;
    if (closed_) ++counts_.discarded;
    return !closed_;
  }

  mutable std::mutex mutex_;
  std::condition_variable put_;
  std::condition_variable taken_;
  std::optional<Item> waiting_;
  std::uint64_t next_ticket_ = 0;
  QueueCounts counts_;
  bool closed_ = false;
};

}  // namespace chequer
