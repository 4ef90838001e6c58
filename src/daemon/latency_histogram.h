#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace chequer {

/// Distribution of times in fixed memory: exact to 3 % or 1 µs, whichever is more. One thread.
class LatencyHistogram {
 public:
  /// Negative times (a clock of another host) count as 0, times from 2^35 µs (nine hours) on as that.
  void Add(std::chrono::microseconds time);

  std::uint64_t count() const { return count_; }
  /// The longest, exactly; 0 if there was none.
  std::chrono::microseconds worst() const { return worst_; }
  /// The time that the given fraction (0..1) of the times does not exceed; 0 if there was none.
  std::chrono::microseconds Quantile(double fraction) const;

  void Clear();

 private:
  // 32 buckets for each doubling: a bucket's middle is within 1/64 of all in it.
  static constexpr int kStepBits = 5;
  static constexpr std::size_t kSteps = 1u << kStepBits;
  static constexpr int kMaxBits = 35;  // 2^35 µs are 9.5 hours
  static constexpr std::size_t kBuckets = (kMaxBits - kStepBits + 1) * kSteps;

  static std::size_t BucketOf(std::uint64_t microseconds);
  static std::uint64_t MiddleOf(std::size_t bucket);

  std::array<std::uint32_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  std::chrono::microseconds worst_{};
};

}  // namespace chequer
