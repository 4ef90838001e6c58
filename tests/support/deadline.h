#pragma once

#include <chrono>
#include <thread>

namespace chequer::test {

/// How long a test waits for another thread before it fails: longer than any machine needs, shorter than CTest's limit.
constexpr std::chrono::seconds kPatience{20};

/// Gives way to other threads until a condition holds; false when it does not in time, so that a test fails where it
/// would never end.
template <typename Condition>
bool ComesTrue(Condition condition) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

}  // namespace chequer::test
