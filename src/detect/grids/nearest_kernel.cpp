#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/grids/nearest_kernel.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <algorithm>

#include "detect/grids/nearest_kernel.h"

#ifndef CHEQUER_DETECT_NEAREST_KERNEL
#define CHEQUER_DETECT_NEAREST_KERNEL
namespace chequer {
namespace nearest {

/// Squared cosine of how far the neighbour may lie off the ray (25 degrees), at both ends (a guess).
constexpr float kLeastSquaredCosine = 0.906f * 0.906f;
/// How much more a candidate that lies off the ray has to be nearer: a share of the square of how far it lies off (a
/// guess).
constexpr float kOffAxisCost = 3;
/// Largest ratio of the contrasts of neighbours (a guess).
constexpr float kMostContrastRatio = 4;
/// Corners that are nearer to each other are the same corner, px (a guess).
constexpr float kShortest = 2;

}  // namespace nearest
}  // namespace chequer
#endif  // CHEQUER_DETECT_NEAREST_KERNEL

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kCornersAtOnce>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;

/// Whether corners may be another's neighbours, by the square of their distance and their contrast.
HWY_INLINE hn::Mask<D> MayBeNeighbours(V square, V other, V contrast, float longest) {
  const D d;
  const V ratio = hn::Set(d, nearest::kMostContrastRatio);
  const auto fits = hn::And(hn::Gt(square, hn::Set(d, nearest::kShortest * nearest::kShortest)),
                            hn::Lt(square, hn::Set(d, longest * longest)));
  return hn::And(fits, hn::And(hn::Gt(hn::Mul(other, ratio), contrast), hn::Lt(other, hn::Mul(contrast, ratio))));
}

/// @param back along the rays of the corners, to the one.
HWY_INLINE hn::Vec<DI> KeysOf(V square, V squared_along, V handicap, V back, hn::Vec<DI> twice_place) {
  const D d;
  const DI di;
  // d² + 3 (d² − along²), where the square of d + 1.5 (d − along) would need a root.
  const V longer = hn::MulAdd(hn::Set(d, nearest::kOffAxisCost), hn::Sub(square, squared_along), square);
  const auto distance = hn::BitCast(di, hn::Mul(handicap, longer));
  const auto leads_back = hn::ShiftRight<31>(hn::BitCast(hn::RebindToUnsigned<DI>(), back));
  return hn::Or(hn::And(distance, hn::Set(di, -1 << NearestKeys::kIndexBits)),
                hn::Or(twice_place, hn::BitCast(di, leads_back)));
}

/// Replaces `keys`.
void Nearest(const CornerTable& corners, int from, const CornerRange* ranges, std::size_t count, float longest,
             NearestKeys& keys) {
  using T = CornerTable;
  const D d;
  const DI di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto own = [&](std::size_t k) HWY_ATTR { return hn::Set(d, corners.column(k)[from]); };
  const V x = own(T::kX), y = own(T::kY), contrast = own(T::kContrast);
  const V ray0_x = own(T::kRay0X), ray0_y = own(T::kRay0Y), ray1_x = own(T::kRay1X), ray1_y = own(T::kRay1Y);
  const V cosine = hn::Set(d, nearest::kLeastSquaredCosine), zero = hn::Zero(d);
  const auto none = hn::Set(di, NearestKeys::kNone);
  // The places, counted up: in the loop, Iota would be built in memory anew.
  auto twice_place = hn::ShiftLeft<1>(hn::Iota(di, 0));
  const auto twice_lanes = hn::Set(di, 2 * lanes);
  auto key0 = none, key1 = none, key2 = none, key3 = none;
  for (std::size_t range = 0; range < count; ++range)
    for (int offset = 0; offset < kCornersAtOnce; offset += lanes) {
      const int i = ranges[range][0] + offset, left = std::max(ranges[range][1] - i, 0);
      const auto column = [&](std::size_t k) HWY_ATTR { return hn::LoadU(d, corners.column(k) + i); };
      const V dx = hn::Sub(column(T::kX), x), dy = hn::Sub(column(T::kY), y);
      const V square = hn::MulAdd(dx, dx, hn::Mul(dy, dy));
      const V least = hn::Mul(square, cosine);
      // Along the rays of the one, and of the other.
      const V along0 = hn::MulAdd(ray0_x, dx, hn::Mul(ray0_y, dy)),
              along1 = hn::MulAdd(ray1_x, dx, hn::Mul(ray1_y, dy));
      const V back0 = hn::MulAdd(column(T::kRay0X), dx, hn::Mul(column(T::kRay0Y), dy));
      const V back1 = hn::MulAdd(column(T::kRay1X), dx, hn::Mul(column(T::kRay1Y), dy));
      const V squared0 = hn::Mul(along0, along0), squared1 = hn::Mul(along1, along1);
      const auto on0 = hn::Gt(hn::Min(squared0, hn::Mul(back1, back1)), least);
      const auto on1 = hn::Gt(hn::Min(squared1, hn::Mul(back0, back0)), least);
      const V a0 = hn::IfThenElseZero(on0, squared0), a1 = hn::IfThenElseZero(on1, squared1);
      const auto second = hn::Gt(a1, a0);
      const V along = hn::IfThenElse(second, along1, along0), back = hn::IfThenElse(second, back0, back1);
      const auto key = KeysOf(square, hn::Max(a0, a1), column(T::kHandicap), back, twice_place);
      auto fits = MayBeNeighbours(square, column(T::kContrast), contrast, longest);
      fits = hn::And(fits, hn::And(hn::Or(on0, on1), hn::FirstN(d, static_cast<std::size_t>(left))));
      const auto forward = hn::And(fits, hn::Gt(along, zero)), backward = hn::AndNot(hn::Gt(along, zero), fits);
      const auto keep = [&](auto on_ray, auto& best)
                            HWY_ATTR { best = hn::Min(best, hn::IfThenElse(hn::RebindMask(di, on_ray), key, none)); };
      keep(hn::AndNot(second, forward), key0);
      keep(hn::And(second, forward), key1);
      keep(hn::AndNot(second, backward), key2);
      keep(hn::And(second, backward), key3);
      twice_place = hn::Add(twice_place, twice_lanes);
    }
  keys.key = {hn::GetLane(hn::MinOfLanes(di, key0)), hn::GetLane(hn::MinOfLanes(di, key1)),
              hn::GetLane(hn::MinOfLanes(di, key2)), hn::GetLane(hn::MinOfLanes(di, key3))};
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(Nearest);

}  // namespace

NearestKeys FindNearest(const CornerTable& corners, int from, std::span<const CornerRange> ranges, float longest) {
  NearestKeys keys;
  HWY_DYNAMIC_DISPATCH(Nearest)
  (corners, from, ranges.data(), std::min(ranges.size(), NearestKeys::kMostRanges), longest, keys);
  return keys;
}

}  // namespace chequer
#endif  // HWY_ONCE
