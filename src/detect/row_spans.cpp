#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/row_spans.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include "detect/row_spans.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void FindSpans(const CrossedBands& region, int row, RowSpans& spans) {
  const hn::CappedTag<float, RowSpans::kRows> d;
  const hn::RebindToSigned<decltype(d)> di;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
  const V left = set(region.left), past = set(region.right + 1), point_x = set(region.point_x);
  for (int i = 0; i < RowSpans::kRows; i += lanes) {
    const V dy = hn::Sub(hn::Iota(d, static_cast<float>(row + i)), set(region.point_y));
    const auto at = [&](float from, float slope) HWY_ATTR { return hn::MulAdd(set(slope), dy, set(from)); };
    const Band &a = region.bands[0], &b = region.bands[1];
    const V from = hn::Add(hn::Max(at(a.low, a.slope), at(b.low, b.slope)), point_x);
    const V to = hn::Add(hn::Min(at(a.high, a.slope), at(b.high, b.slope)), point_x);
    const V first = hn::Ceil(hn::Min(hn::Max(from, left), past));
    const V last = hn::Floor(hn::Max(hn::Min(to, set(region.right)), hn::Sub(left, set(1.0f))));
    hn::Store(hn::ConvertTo(di, first), di, spans.first + i);
    hn::Store(hn::ConvertTo(di, hn::Add(hn::Sub(last, first), set(1.0f))), di, spans.pixels + i);

    const V dx = hn::Sub(first, point_x);
    const LocalPlane& p = region.plane;
    const auto coordinate = [&](std::size_t k, float* value, float* step) HWY_ATTR {
      const V slope = hn::MulAdd(dy, set(p.by_xy[k]), set(p.by_x[k])), bend = set(p.by_xx[k]);
      const V down = hn::MulAdd(dy, hn::MulAdd(dy, set(p.by_yy[k]), set(p.by_y[k])), set(p.at[k]));
      hn::Store(hn::MulAdd(dx, hn::MulAdd(dx, bend, slope), down), d, value + i);
      hn::Store(hn::MulAdd(hn::Add(hn::Add(dx, dx), set(1.0f)), bend, slope), d, step + i);
    };
    coordinate(0, spans.u, spans.step_u);
    coordinate(1, spans.v, spans.step_v);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace chequer {
namespace {

HWY_EXPORT(FindSpans);

}  // namespace

void FindRowSpans(const CrossedBands& region, int row, RowSpans& spans) {
  HWY_DYNAMIC_DISPATCH(FindSpans)(region, row, spans);
}

}  // namespace chequer
#endif  // HWY_ONCE
