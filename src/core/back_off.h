#pragma once

#include <algorithm>
#include <chrono>

namespace chequer {

/// How long to wait before trying again: doubling from `first` up to `longest`.
class BackOff {
 public:
  BackOff(std::chrono::milliseconds first, std::chrono::milliseconds longest)
      : first_(first), longest_(longest), next_(first) {}

  /// The wait after one more failure.
  std::chrono::milliseconds Failed() {
    const auto wait = next_;
    next_ = std::min(2 * next_, longest_);
    return wait;
  }
  void Succeeded() { next_ = first_; }

 private:
  std::chrono::milliseconds first_;
  std::chrono::milliseconds longest_;
  std::chrono::milliseconds next_;
};

}  // namespace chequer
