#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/corners/corner_response.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <cstdint>

#include "detect/corners/corner_response.h"

#ifndef CHEQUER_DETECT_CORNER_RESPONSE
#define CHEQUER_DETECT_CORNER_RESPONSE
namespace chequer {
namespace corner_response {

/// Columns of peaks that are written whether they are there or not: of 64 pixels, few have more.
constexpr int kAtOnce = 4;

}  // namespace corner_response
}  // namespace chequer
#endif  // CHEQUER_DETECT_CORNER_RESPONSE

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Saturating differences would take as many instructions, of which some processors do half as many at a time.
template <class V>
V AbsoluteDifference(V a, V b) {
  return hn::Sub(hn::Max(a, b), hn::Min(a, b));
}

/// Pixels of a row that are worked on together.
using D = hn::CappedTag<std::uint8_t, 32>;

/// One row of the response, from column kRingMargin; may write into the row's tail. Fills `strong` with the first
/// columns of the vectors that reach the threshold somewhere; returns how many there are.
int ResponseRow(const std::uint8_t* center, std::ptrdiff_t stride, int width, std::uint8_t threshold, std::uint8_t* out,
                std::uint16_t* strong) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto least = hn::Set(d, threshold);
  int count = 0;
  // Half the ring, an eighth of a turn each; entry k + 2 lies a quarter turn on from entry k.
  constexpr std::size_t kPairs = 4;
  const std::ptrdiff_t ring[kPairs] = {3, 2 + 2 * stride, 3 * stride, -2 + 2 * stride};
  for (int x = kRingMargin; x < width - kRingMargin; x += lanes) {
    const std::uint8_t* p = center + x;
    hn::Vec<decltype(d)> mean[kPairs], difference[kPairs];
    for (std::size_t k = 0; k < kPairs; ++k) {
      const auto a = hn::LoadU(d, p + ring[k]);
      const auto b = hn::LoadU(d, p - ring[k]);
      mean[k] = hn::AverageRound(a, b);
      difference[k] = AbsoluteDifference(a, b);
    }
    // Each for itself: where edges run through the points of one square, what it misses takes nothing from the other.
    const auto saddle_of_square = [&](std::size_t k) HWY_ATTR {
      return hn::SaturatedSub(AbsoluteDifference(mean[k], mean[k + 2]),
                              hn::AverageRound(difference[k], difference[k + 2]));
    };
    const auto saddle = hn::AverageRound(saddle_of_square(0), saddle_of_square(1));
    const auto ring_mean = hn::AverageRound(hn::AverageRound(mean[0], mean[2]), hn::AverageRound(mean[1], mean[3]));
    // Where edges run between pixels, no pixel is the middle of a corner: those around it are.
    const auto middle = hn::AverageRound(hn::AverageRound(hn::LoadU(d, p - 1), hn::LoadU(d, p + 1)),
                                         hn::AverageRound(hn::LoadU(d, p - stride), hn::LoadU(d, p + stride)));
    const auto response = hn::SaturatedSub(saddle, AbsoluteDifference(ring_mean, middle));
    hn::StoreU(response, d, out + x);
    strong[count] = static_cast<std::uint16_t>(x);
    // response ≥ threshold ⇔ max(response, threshold) = response.
    count += !hn::AllFalse(d, hn::Eq(hn::Max(response, least), response));
  }
  return count;
}

/// Fills `columns` with the peaks of a row, of the vectors that begin at `strong`; returns how many there are. Nothing
/// branches on where peaks are, which would be guessed wrong in clutter.
int PeaksOfRow(const std::uint8_t* row_above, const std::uint8_t* row, const std::uint8_t* row_below,
               std::uint8_t threshold, const std::uint16_t* strong, int strong_count, std::uint16_t* columns) {
  const D d;
  const auto least = hn::Set(d, threshold);
  int count = 0;
  for (int k = 0; k < strong_count; ++k) {
    const int x = strong[k];
    const std::uint8_t *p = row + x, *above = row_above + x, *below = row_below + x;
    const auto value = hn::LoadU(d, p);
    // Of equal neighbours the last in reading order is the peak.
    const auto after = hn::Max(hn::Max(hn::LoadU(d, p + 1), hn::LoadU(d, below - 1)),
                               hn::Max(hn::LoadU(d, below), hn::LoadU(d, below + 1)));
    const auto before = hn::Max(hn::Max(hn::LoadU(d, p - 1), hn::LoadU(d, above + 1)),
                                hn::Max(hn::LoadU(d, above), hn::LoadU(d, above - 1)));
    const auto above_after = hn::Ne(hn::Max(after, value), after);
    const auto not_below_before = hn::Eq(hn::Max(hn::Max(before, least), value), value);
    const auto peak = hn::And(above_after, not_below_before);
    std::uint64_t bits = 0;
    hn::StoreMaskBits(d, peak, reinterpret_cast<std::uint8_t*>(&bits));
    const int found = std::popcount(bits);
    for (int i = 0; i < corner_response::kAtOnce; ++i, bits &= bits - 1)
      columns[count + i] = static_cast<std::uint16_t>(x + std::countr_zero(bits));
    for (int i = corner_response::kAtOnce; i < found; ++i, bits &= bits - 1)
      columns[count + i] = static_cast<std::uint16_t>(x + std::countr_zero(bits));
    count += found;
  }
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cstring>

namespace chequer {
namespace {

HWY_EXPORT(ResponseRow);
HWY_EXPORT(PeaksOfRow);

}  // namespace

void PeakScan::Start(const BytePlane& plane, std::uint8_t threshold) {
  threshold_ = threshold;
  next_ = kRingMargin;
  peaks_.clear();
  response_.Resize(plane.width(), kKept);
  std::memset(response_.row(0), 0, static_cast<std::size_t>(kKept * response_.stride()));
  const std::size_t most = static_cast<std::size_t>(plane.width() + corner_response::kAtOnce);
  for (Strong& strong : strong_) {
    strong.columns.Resize(most);
    strong.count = 0;
  }
  columns_.Resize(most);
}

void PeakScan::Advance(const BytePlane& plane, int rows) {
  const int width = plane.width(), past = plane.height() - kRingMargin;
  if (width <= 2 * kRingMargin || past <= kRingMargin) return;
  for (; next_ < std::min(rows - kRingMargin, past); ++next_) {
    std::uint8_t* row = response_.row(next_ % kKept);
    Strong& strong = strong_[static_cast<std::size_t>(next_ % kKept)];
    strong.count = HWY_DYNAMIC_DISPATCH(ResponseRow)(plane.row(next_), plane.stride(), width, threshold_, row,
                                                     strong.columns.data());
    // Vectors run over the end.
    std::memset(row + width - kRingMargin, 0, static_cast<std::size_t>(response_.stride() - width + kRingMargin));
    if (next_ > kRingMargin) FindPeaks(next_ - 1);
  }
  if (rows < plane.height() || next_ > past) return;
  std::memset(response_.row(past % kKept), 0, static_cast<std::size_t>(response_.stride()));
  FindPeaks(past - 1);
  ++next_;
}

void PeakScan::FindPeaks(int y) {
  const Strong& strong = strong_[static_cast<std::size_t>(y % kKept)];
  const std::uint8_t *above = response_.row((y - 1) % kKept), *row = response_.row(y % kKept),
                     *below = response_.row((y + 1) % kKept);
  const int count = HWY_DYNAMIC_DISPATCH(PeaksOfRow)(above, row, below, threshold_, strong.columns.data(), strong.count,
                                                     columns_.data());
  const std::size_t before = peaks_.size();
  peaks_.resize(before + static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    const std::uint16_t x = columns_[static_cast<std::size_t>(k)];
    peaks_[before + static_cast<std::size_t>(k)] = {
        x, static_cast<std::uint16_t>(y), row[x], row[x - 1], row[x + 1], above[x], below[x]};
  }
}

}  // namespace chequer
#endif  // HWY_ONCE
