#include "daemon/latency_histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace chequer {

std::size_t LatencyHistogram::BucketOf(std::uint64_t microseconds) {
  if (microseconds < kSteps) return static_cast<std::size_t>(microseconds);
  const int shift = static_cast<int>(std::bit_width(microseconds)) - 1 - kStepBits;
  const std::size_t doubling = static_cast<std::size_t>(shift) + 1;
  return doubling * kSteps + static_cast<std::size_t>((microseconds >> shift) - kSteps);
}

std::uint64_t LatencyHistogram::MiddleOf(std::size_t bucket) {
  if (bucket < kSteps) return bucket;
  const std::size_t shift = bucket / kSteps - 1;
  const std::uint64_t low = (bucket % kSteps + kSteps) << shift;
  return low + ((std::uint64_t{1} << shift) >> 1);
}

void LatencyHistogram::Add(std::chrono::microseconds time) {
  constexpr std::uint64_t kLargest = (std::uint64_t{1} << kMaxBits) - 1;
  const std::uint64_t microseconds =
      std::min(kLargest, static_cast<std::uint64_t>(std::max<std::int64_t>(0, time.count())));
  ++buckets_[BucketOf(microseconds)];
  ++count_;
  worst_ = std::max(worst_, std::chrono::microseconds(microseconds));
}

std::chrono::microseconds LatencyHistogram::Quantile(double fraction) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(fraction * static_cast<double>(count_)));
  std::uint64_t below = 0;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    below += buckets_[bucket];
    if (below > 0 && below >= wanted) return std::min(worst_, std::chrono::microseconds(MiddleOf(bucket)));
  }
  return worst_;
}

void LatencyHistogram::Clear() { *this = {}; }

}  // namespace chequer
