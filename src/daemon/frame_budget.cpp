#include "daemon/frame_budget.h"

#include <algorithm>

namespace chequer {

FrameBudget FrameBudget::Units(std::uint64_t units) {
  FrameBudget budget;
  budget.units_ = units;
  return budget;
}

FrameBudget FrameBudget::Auto(double units_per_second, int workers) {
  FrameBudget budget;
  budget.units_per_second_ = units_per_second * std::min(kShare * workers, kMostIntervals);
  return budget;
}

std::uint64_t FrameBudget::For(double rate_hz) const {
  if (!(units_per_second_ > 0) || !(rate_hz > 0)) return units_;
  return std::max(static_cast<std::uint64_t>(units_per_second_ / rate_hz), kLeastAuto);
}

}  // namespace chequer
