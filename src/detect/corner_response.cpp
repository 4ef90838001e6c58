#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/corner_response.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include "detect/corner_response.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class V>
V AbsoluteDifference(V a, V b) {
  return hn::Or(hn::SaturatedSub(a, b), hn::SaturatedSub(b, a));
}

/// ¼ a + ½ b + ¼ c: the mean of the three in two instructions, with the weights that this costs.
template <class V>
V MeanOfThree(V a, V b, V c) {
  return hn::AverageRound(hn::AverageRound(a, b), hn::AverageRound(b, c));
}

/// One row of the response, from column kRingMargin; may write into the row's tail.
void ResponseRow(const std::uint8_t* center, std::ptrdiff_t stride, int width, std::uint8_t* out) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  // Half the ring, a sixth of a turn each; entry k + 3 lies a quarter turn on from entry k.
  const std::ptrdiff_t ring[6] = {3 + stride,      2 + 2 * stride,  1 + 3 * stride,
                                  -1 + 3 * stride, -2 + 2 * stride, -3 + stride};
  for (int x = kRingMargin; x < width - kRingMargin; x += lanes) {
    const std::uint8_t* p = center + x;
    hn::Vec<decltype(d)> pair_mean[6], pair_difference[6];
    for (int k = 0; k < 6; ++k) {
      const auto a = hn::LoadU(d, p + ring[k]);
      const auto b = hn::LoadU(d, p - ring[k]);
      pair_mean[k] = hn::AverageRound(a, b);
      pair_difference[k] = AbsoluteDifference(a, b);
    }
    const auto saddle =
        MeanOfThree(AbsoluteDifference(pair_mean[0], pair_mean[3]), AbsoluteDifference(pair_mean[1], pair_mean[4]),
                    AbsoluteDifference(pair_mean[2], pair_mean[5]));
    const auto edge = MeanOfThree(hn::AverageRound(pair_difference[0], pair_difference[3]),
                                  hn::AverageRound(pair_difference[1], pair_difference[4]),
                                  hn::AverageRound(pair_difference[2], pair_difference[5]));
    const auto mean =
        MeanOfThree(hn::AverageRound(pair_mean[0], pair_mean[3]), hn::AverageRound(pair_mean[1], pair_mean[4]),
                    hn::AverageRound(pair_mean[2], pair_mean[5]));
    const auto off_center = AbsoluteDifference(mean, hn::LoadU(d, p));
    hn::StoreU(hn::SaturatedSub(hn::SaturatedSub(saddle, edge), off_center), d, out + x);
  }
}

/// Calls nothing where a whole vector stays below the threshold, which is nearly everywhere.
void PeaksOfRow(const std::uint8_t* row_above, const std::uint8_t* row, const std::uint8_t* row_below, int y, int width,
                std::uint8_t threshold, std::vector<Peak>& peaks) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto least = hn::Set(d, threshold);
  for (int x = kRingMargin; x < width - kRingMargin; x += lanes) {
    const std::uint8_t *p = row + x, *above = row_above + x, *below = row_below + x;
    const auto value = hn::LoadU(d, p);
    // value ≥ threshold ⇔ max(value, threshold) = value.
    const auto strong = hn::Eq(hn::Max(value, least), value);
    if (hn::AllFalse(d, strong)) continue;
    // Of equal neighbours the last in reading order is the peak.
    const auto after = hn::Max(hn::Max(hn::LoadU(d, p + 1), hn::LoadU(d, below - 1)),
                               hn::Max(hn::LoadU(d, below), hn::LoadU(d, below + 1)));
    const auto before = hn::Max(hn::Max(hn::LoadU(d, p - 1), hn::LoadU(d, above + 1)),
                                hn::Max(hn::LoadU(d, above), hn::LoadU(d, above - 1)));
    const auto above_after = hn::Ne(hn::Max(after, value), after);
    const auto not_below_before = hn::Eq(hn::Max(before, value), value);
    const auto peak = hn::And(strong, hn::And(above_after, not_below_before));
    if (hn::AllFalse(d, peak)) continue;
    std::uint64_t words[(HWY_MAX_BYTES + 63) / 64 + 1] = {};
    hn::StoreMaskBits(d, peak, reinterpret_cast<std::uint8_t*>(words));
    for (int first = 0; first < lanes; first += 64)
      for (std::uint64_t bits = words[first / 64]; bits != 0; bits &= bits - 1) {
        const int i = first + __builtin_ctzll(bits);
        if (i >= lanes || x + i >= width - kRingMargin) break;
        peaks.push_back({static_cast<std::uint16_t>(x + i), static_cast<std::uint16_t>(y), p[i], p[i - 1], p[i + 1],
                         above[i], below[i]});
      }
  }
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
}

void PeakScan::Advance(const BytePlane& plane, int rows) {
  const int width = plane.width(), past = plane.height() - kRingMargin;
  if (width <= 2 * kRingMargin || past <= kRingMargin) return;
  for (; next_ < std::min(rows - kRingMargin, past); ++next_) {
    std::uint8_t* row = response_.row(next_ % kKept);
    HWY_DYNAMIC_DISPATCH(ResponseRow)(plane.row(next_), plane.stride(), width, row);
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
  const auto row = [&](int at) { return response_.row(at % kKept); };
  HWY_DYNAMIC_DISPATCH(PeaksOfRow)
  (row(y - 1), row(y), row(y + 1), y, response_.width(), threshold_, peaks_);
}

}  // namespace chequer
#endif  // HWY_ONCE
