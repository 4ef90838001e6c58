#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/corners/saddle.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <cstddef>

#include "detect/corners/saddle.h"

#ifndef CHEQUER_DETECT_SADDLE
#define CHEQUER_DETECT_SADDLE
namespace chequer {
namespace saddle {

constexpr int kRing = 12;
/// By growing angle from (3, 1).
constexpr int kRingX[kRing] = {3, 2, 1, -1, -2, -3, -3, -2, -1, 1, 2, 3};
constexpr int kRingY[kRing] = {1, 2, 3, 3, 2, 1, -1, -2, -3, -3, -2, -1};

/// Least share of the contrast in the response: see PeakScan for that of corners; clutter has mostly less (a guess).
constexpr float kLeastShare = 0.10f;
/// Cosine of how far opposite edges may be from a straight line (43 degrees; a guess).
constexpr float kStraight = 0.73f;

/// Peaks that are looked at together: the lanes of the widest vectors (AVX-512).
constexpr std::size_t kMost = 16;

/// Values of some peaks, a peak a lane.
struct Batch {
  alignas(64) std::int32_t ring[kRing][kMost];
  alignas(64) std::int32_t response[kMost], before[2][kMost], after[2][kMost];  ///< along x, along y
  // What comes out.
  alignas(64) float contrast[kMost], middle[kMost], rising[2][kMost], falling[2][kMost], off_peak[2][kMost];
};

}  // namespace saddle
}  // namespace chequer
#endif  // CHEQUER_DETECT_SADDLE

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, saddle::kMost>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;

/// Where the ring crosses between light and dark.
struct Crossing {
  V x, y;
};

/// The crossing after the place of the ring whose bit is set, one bit in each lane.
HWY_INLINE Crossing CrossingAt(D d, VI bit, const VI* ring, V middle) {
  using saddle::kRing, saddle::kRingX, saddle::kRingY;
  const DI di;
  VI from = ring[0], to = ring[1];
  V from_x = hn::Set(d, static_cast<float>(kRingX[0])), from_y = hn::Set(d, static_cast<float>(kRingY[0]));
  V step_x = hn::Set(d, static_cast<float>(kRingX[1] - kRingX[0]));
  V step_y = hn::Set(d, static_cast<float>(kRingY[1] - kRingY[0]));
  for (int i = 1; i < kRing; ++i) {
    const int next = (i + 1) % kRing;
    const auto here = hn::Eq(bit, hn::Set(di, 1 << i));
    const auto here_float = hn::RebindMask(d, here);
    from = hn::IfThenElse(here, ring[i], from);
    to = hn::IfThenElse(here, ring[next], to);
    from_x = hn::IfThenElse(here_float, hn::Set(d, static_cast<float>(kRingX[i])), from_x);
    from_y = hn::IfThenElse(here_float, hn::Set(d, static_cast<float>(kRingY[i])), from_y);
    step_x = hn::IfThenElse(here_float, hn::Set(d, static_cast<float>(kRingX[next] - kRingX[i])), step_x);
    step_y = hn::IfThenElse(here_float, hn::Set(d, static_cast<float>(kRingY[next] - kRingY[i])), step_y);
  }
  const V value = hn::ConvertTo(d, from);
  const V part = hn::Div(hn::Sub(value, middle), hn::Sub(value, hn::ConvertTo(d, to)));
  return {hn::MulAdd(part, step_x, from_x), hn::MulAdd(part, step_y, from_y)};
}

/// Half a turn apart, to kStraight.
HWY_INLINE hn::Mask<D> AreOpposite(D d, const Crossing& a, const Crossing& b) {
  const V dot = hn::MulAdd(a.x, b.x, hn::Mul(a.y, b.y));
  const V squares = hn::Mul(hn::MulAdd(a.x, a.x, hn::Mul(a.y, a.y)), hn::MulAdd(b.x, b.x, hn::Mul(b.y, b.y)));
  const V least = hn::Mul(hn::Set(d, saddle::kStraight * saddle::kStraight), squares);
  return hn::And(hn::Lt(dot, hn::Zero(d)), hn::Gt(hn::Mul(dot, dot), least));
}

HWY_INLINE Crossing Direction(D d, const Crossing& to, const Crossing& from) {
  const V x = hn::Sub(to.x, from.x), y = hn::Sub(to.y, from.y);
  const V scale = hn::Div(hn::Set(d, 1.0f), hn::Sqrt(hn::MulAdd(x, x, hn::Mul(y, y))));
  return {hn::Mul(x, scale), hn::Mul(y, scale)};
}

/// Peak of a parabola through three values, −½..½.
HWY_INLINE V ParabolaPeak(D d, VI before, VI middle, VI after) {
  const VI curvature = hn::Sub(hn::Add(middle, middle), hn::Add(before, after));
  const V half = hn::Set(d, 0.5f), bend = hn::ConvertTo(d, curvature);
  const V peak = hn::Div(hn::Mul(half, hn::ConvertTo(d, hn::Sub(after, before))), hn::Max(bend, half));
  return hn::IfThenElseZero(hn::Gt(bend, hn::Zero(d)), hn::Min(hn::Max(peak, hn::Neg(half)), half));
}

/// A ring a lane, and what tells its light from its dark places.
struct Ring {
  VI values[saddle::kRing];
  V contrast, middle;
  hn::Mask<D> is_uneven;
};

HWY_INLINE Ring ReadRing(D d, const saddle::Batch& batch, std::size_t first) {
  using saddle::kRing;
  const DI di;
  Ring ring;
  VI sum = hn::Zero(di);
  for (int i = 0; i < kRing; ++i) {
    ring.values[i] = hn::Load(di, batch.ring[i] + first);
    sum = hn::Add(sum, ring.values[i]);
  }
  VI light_sum = hn::Zero(di), light_count = hn::Zero(di);
  for (int i = 0; i < kRing; ++i) {
    // Lighter than the mean.
    const auto is_light = hn::Gt(hn::Mul(ring.values[i], hn::Set(di, kRing)), sum);
    light_sum = hn::Add(light_sum, hn::IfThenElseZero(is_light, ring.values[i]));
    light_count = hn::Add(light_count, hn::IfThenElseZero(is_light, hn::Set(di, 1)));
  }
  // A flat ring has none, which leads to no crossing.
  const V light = hn::Div(hn::ConvertTo(d, light_sum), hn::ConvertTo(d, hn::Max(light_count, hn::Set(di, 1))));
  const V dark =
      hn::Div(hn::ConvertTo(d, hn::Sub(sum, light_sum)), hn::ConvertTo(d, hn::Sub(hn::Set(di, kRing), light_count)));
  ring.contrast = hn::Sub(light, dark);
  ring.middle = hn::Mul(hn::Add(light, dark), hn::Set(d, 0.5f));
  ring.is_uneven = hn::RebindMask(d, hn::Gt(light_count, hn::Zero(di)));
  return ring;
}

/// Bits of the places where a ring gets lighter or darker, and of the last of them.
struct Changes {
  VI rises, last_rise, falls, last_fall;
  hn::Mask<D> are_two;
};

HWY_INLINE Changes ChangesOf(D d, const Ring& ring) {
  using saddle::kRing;
  const DI di;
  VI lighter = hn::Zero(di);
  for (int i = 0; i < kRing; ++i) {
    const auto is_lighter = hn::RebindMask(di, hn::Ge(hn::ConvertTo(d, ring.values[i]), ring.middle));
    lighter = hn::Or(lighter, hn::IfThenElseZero(is_lighter, hn::Set(di, 1 << i)));
  }
  const VI next_lighter =
      hn::And(hn::Or(hn::ShiftRight<1>(lighter), hn::ShiftLeft<kRing - 1>(lighter)), hn::Set(di, (1 << kRing) - 1));
  const VI rises = hn::AndNot(lighter, next_lighter), falls = hn::AndNot(next_lighter, lighter);
  // On a ring, there are as many falls as rises; a saddle has two.
  const VI one = hn::Set(di, 1);
  const VI last_rise = hn::And(rises, hn::Sub(rises, one)), last_fall = hn::And(falls, hn::Sub(falls, one));
  const auto two =
      hn::AndNot(hn::Eq(last_rise, hn::Zero(di)), hn::Eq(hn::And(last_rise, hn::Sub(last_rise, one)), hn::Zero(di)));
  return {rises, last_rise, falls, last_fall, hn::RebindMask(d, two)};
}

/// @param up, down the directions of the edges by which the ring rises and falls.
HWY_INLINE void StoreRays(D d, const Crossing& up, Crossing down, std::size_t first, saddle::Batch& batch) {
  // The falling ray comes within half a turn after the rising one.
  const auto turned = hn::Lt(hn::MulSub(up.x, down.y, hn::Mul(up.y, down.x)), hn::Zero(d));
  down.x = hn::IfThenElse(turned, hn::Neg(down.x), down.x);
  down.y = hn::IfThenElse(turned, hn::Neg(down.y), down.y);
  hn::Store(up.x, d, batch.rising[0] + first);
  hn::Store(up.y, d, batch.rising[1] + first);
  hn::Store(down.x, d, batch.falling[0] + first);
  hn::Store(down.y, d, batch.falling[1] + first);
}

/// Fills in what comes out of the first `count` peaks. Returns a bit for each that is a saddle.
std::uint32_t FindSaddles(std::size_t count, saddle::Batch& batch) {
  const D d;
  const DI di;
  const std::size_t lanes = hn::Lanes(d);
  std::uint32_t found = 0;
  for (std::size_t first = 0; first < count; first += lanes) {
    const Ring ring = ReadRing(d, batch, first);
    hn::Store(ring.contrast, d, batch.contrast + first);
    hn::Store(ring.middle, d, batch.middle + first);
    const VI top = hn::Load(di, batch.response + first);
    auto is_saddle = hn::Ge(hn::ConvertTo(d, top), hn::Mul(hn::Set(d, saddle::kLeastShare), ring.contrast));
    const Changes changes = ChangesOf(d, ring);
    is_saddle = hn::And(is_saddle, hn::And(ring.is_uneven, changes.are_two));
    if (hn::AllFalse(d, is_saddle)) continue;

    const auto crossing = [&](VI bit) HWY_ATTR { return CrossingAt(d, bit, ring.values, ring.middle); };
    const Crossing rise0 = crossing(hn::AndNot(changes.last_rise, changes.rises)), rise1 = crossing(changes.last_rise);
    const Crossing fall0 = crossing(hn::AndNot(changes.last_fall, changes.falls)), fall1 = crossing(changes.last_fall);
    is_saddle = hn::And(is_saddle, hn::And(AreOpposite(d, rise0, rise1), AreOpposite(d, fall0, fall1)));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, is_saddle, bits);
    for (std::size_t i = 0; i < lanes && first + i < count; ++i)
      found |= static_cast<std::uint32_t>(bits[i / 8] >> i % 8 & 1) << (first + i);
    StoreRays(d, Direction(d, rise0, rise1), Direction(d, fall0, fall1), first, batch);
    for (int axis = 0; axis < 2; ++axis)
      hn::Store(ParabolaPeak(d, hn::Load(di, batch.before[axis] + first), top, hn::Load(di, batch.after[axis] + first)),
                d, batch.off_peak[axis] + first);
  }
  return found;
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <array>
#include <cmath>

namespace chequer {
namespace {

HWY_EXPORT(FindSaddles);

/// How many peaks ahead the memory is asked for what lies around them.
constexpr std::size_t kAhead = 16;
/// Largest difference of a corner's own value from the middle of its light and dark, as a share of the contrast. Half a
/// pixel off, a corner of a sharp image differs by 0.3; the inside of a cell that is narrower than the ring by 0.5.
constexpr float kMostOffMiddle = 0.4f;

/// Nearer corners are two peaks of one corner, as where edges run between pixels, px. Corners of boards are farther
/// apart (a guess).
constexpr float kTwinPx = 1.5f;

/// Peaks of one corner lie in rows no farther apart: its place is half a pixel off each of them at most.
constexpr std::size_t kTwinRows = 4;
/// Along a row, corners come by their peaks' columns, to so many pixels: a place between two peaks lies off both (a
/// guess).
constexpr float kRowOrderPx = 4;

/// Where the corners of the last few rows of peaks begin. Looking for a corner's twin in all of them would take, in a
/// dense texture, as many steps for each corner as a row of the image has corners.
class RecentRows {
 public:
  /// The corner at `index` comes next. Rows do not come back.
  void Add(int row, std::size_t index) {
    if (count_ > 0 && rows_[0].row == row) return;
    std::shift_right(rows_.begin(), rows_.end(), 1);
    rows_[0] = {row, index};
    count_ = std::min(count_ + 1, rows_.size());
  }
  /// Of the corners before the last, the newest that the last is a second peak of, or null.
  Corner* TwinOfLast(std::span<Corner> corners) const {
    std::size_t past = corners.size() - 1;
    const Eigen::Vector2f at = corners.back().position;
    for (std::size_t row = 0; row < count_; ++row) {
      const auto first = corners.begin() + static_cast<std::ptrdiff_t>(rows_[row].first),
                 last = corners.begin() + static_cast<std::ptrdiff_t>(past);
      auto near = std::partition_point(
          first, last, [&](const Corner& corner) { return corner.position.x() < at.x() + kRowOrderPx; });
      for (; near != first && (near - 1)->position.x() > at.x() - kRowOrderPx; --near)
        if (((near - 1)->position - at).squaredNorm() < kTwinPx * kTwinPx) return &*(near - 1);
      past = rows_[row].first;
    }
    return nullptr;
  }

 private:
  struct Row {
    int row = 0;
    std::size_t first = 0;
  };
  std::array<Row, kTwinRows> rows_;  ///< the newest first
  std::size_t count_ = 0;
};

void AskFor(const BytePlane& plane, const Peak& peak) {
  for (int y = -3; y <= 3; ++y) __builtin_prefetch(plane.row(peak.y + y) + peak.x);
}

}  // namespace

void AppendSaddles(const BytePlane& plane, std::span<const Peak> peaks, std::vector<Corner>& corners,
                   std::vector<RefusedPeak>& refused, float least_contrast) {
  refused.clear();
  const std::size_t others = corners.size();
  std::array<std::ptrdiff_t, saddle::kRing> ring;
  for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = saddle::kRingY[i] * plane.stride() + saddle::kRingX[i];
  saddle::Batch batch{};
  RecentRows rows;
  for (std::size_t first = 0; first < peaks.size(); first += saddle::kMost) {
    const std::size_t count = std::min(saddle::kMost, peaks.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      if (first + k + kAhead < peaks.size()) AskFor(plane, peaks[first + k + kAhead]);
      const Peak& peak = peaks[first + k];
      const std::uint8_t* center = plane.row(peak.y) + peak.x;
      for (std::size_t i = 0; i < ring.size(); ++i) batch.ring[i][k] = center[ring[i]];
      batch.response[k] = peak.response;
      batch.before[0][k] = peak.left, batch.after[0][k] = peak.right;
      batch.before[1][k] = peak.above, batch.after[1][k] = peak.below;
    }
    const std::uint32_t found = HWY_DYNAMIC_DISPATCH(FindSaddles)(count, batch);
    for (std::size_t k = 0; k < count; ++k) {
      if (!(found >> k & 1)) {
        if (batch.contrast[k] >= least_contrast) refused.push_back({first + k, batch.contrast[k]});
        continue;
      }
      const Peak& peak = peaks[first + k];
      // Number by number: a copy of what was just written in parts would wait for it.
      Corner& corner = corners.emplace_back();
      const float x = static_cast<float>(peak.x) + batch.off_peak[0][k],
                  y = static_cast<float>(peak.y) + batch.off_peak[1][k];
      corner.position.x() = x, corner.position.y() = y;
      rows.Add(peak.y, corners.size() - 1 - others);
      if (Corner* twin = rows.TwinOfLast(std::span(corners).subspan(others))) {
        // It lies between its peaks.
        twin->position.x() = 0.5f * (twin->position.x() + x), twin->position.y() = 0.5f * (twin->position.y() + y);
        corners.pop_back();
        continue;
      }
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const float up = batch.rising[axis][k], down = batch.falling[axis][k];
        corner.rays[0].data()[axis] = up, corner.rays[1].data()[axis] = down;
        corner.rays[2].data()[axis] = -up, corner.rays[3].data()[axis] = -down;
      }
      corner.contrast = batch.contrast[k];
      corner.ridge = std::abs(plane.Bilinear(x, y) - batch.middle[k]) > kMostOffMiddle * corner.contrast;
    }
  }
}

}  // namespace chequer
#endif  // HWY_ONCE
