#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/level_elimination.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include "detect/level_elimination.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {

/// to −= factor · from. The compiler makes vectors of it for each target.
HWY_INLINE void TakeAway(double factor, const double* HWY_RESTRICT from, int count, double* HWY_RESTRICT to) {
  for (int i = 0; i < count; ++i) to[i] -= factor * from[i];
}

bool Eliminate(const LevelSystem& s) {
  for (int col = 0; col < s.levels; ++col) {
    double* const column = s.band + col * s.band_stride;
    const double* const here = s.common + col * s.common_stride;
    if (!(column[0] > 0)) return false;
    const double inverse = 1 / column[0];
    const int last = s.width < s.levels - 1 - col ? s.width : s.levels - 1 - col;
    for (int below = 1; below <= last; ++below) {
      const double factor = column[below] * inverse;
      if (factor == 0) continue;
      TakeAway(factor, column + below, s.width + 1 - below, column + below * s.band_stride);
      TakeAway(factor, here, s.common_stride, s.common + (col + below) * s.common_stride);
    }
    for (int below = 1; below <= s.width; ++below) column[below] *= inverse;
  }
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(Eliminate);

}  // namespace

bool EliminateLevels(const LevelSystem& system) { return HWY_DYNAMIC_DISPATCH(Eliminate)(system); }

}  // namespace chequer
#endif  // HWY_ONCE
