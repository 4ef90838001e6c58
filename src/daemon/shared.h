#pragma once

#include <mutex>
#include <utility>

namespace chequer {

/// A value that one thread writes and others read now and then, always whole.
template <typename Value>
class Shared {
 public:
  Value Get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

  /// Changes the value with `change(value)`, which must be short.
  template <typename Change>
  void Update(Change&& change) {
    const std::lock_guard lock(mutex_);
    std::forward<Change>(change)(value_);
  }

 private:
  mutable std::mutex mutex_;
  Value value_{};
};

}  // namespace chequer
