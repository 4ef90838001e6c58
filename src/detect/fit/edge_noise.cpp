#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/fit/edge_noise.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include "detect/fit/edge_noise.h"
#include "detect/fit/edge_pixels-inl.h"
#include "detect/fit/plain_light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {

/// @tparam kGrown input.grown.
template <bool kGrown>
void AddErrorsOf(const KernelInput& input, const LaneBlock& block, AlikeEdges& x, AlikeEdges& y) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Shared shared = SharedOf(input);
  HWY_ALIGN float edges[EdgeRow::kValuesGrown * EdgePixels::kMaxLanes];
  EdgePixels across_x, across_y;
  for (int first = 0; first < block.padded(); first += lanes) {
    const Model m = ModelOf(shared, block, first);
    const int most = MostOf(block, first);
    std::size_t at = block.Place(first, 0);
    V left = m.count;
    const V step = hn::Set(d, static_cast<float>(AlikeEdges::kStride));
    for (int k = 0; k < most;
         k += AlikeEdges::kStride, at += AlikeEdges::kStride * LaneBlock::kNextPixel, left = hn::Sub(left, step)) {
      const auto inside = hn::Gt(left, hn::Zero(d));
      PlaceAtEdges(m, hn::IfThenElseZero(inside, hn::LoadU(d, block.u_data() + at)),
                   hn::IfThenElseZero(inside, hn::LoadU(d, block.v_data() + at)), edges);
      BlurEdges<kGrown>(m, edges);
      const Predicted p = Predict<kGrown>(m, edges);
      const Weighed w = Weigh(m, p, hn::LoadU(d, block.light_data() + at), inside);
      across_x.Set(hn::Mul(p.ax, shared.px), hn::Mul(p.by_ax, w.root), w.deviation);
      across_y.Set(hn::Mul(p.ay, shared.px), hn::Mul(p.by_ay, w.root), w.deviation);
      across_x.AddTo(x, first, lanes);
      across_y.AddTo(y, first, lanes);
    }
  }
}

void AddErrors(const KernelInput& input, const LaneBlock& block, AlikeEdges& x, AlikeEdges& y) {
  input.grown ? AddErrorsOf<true>(input, block, x, y) : AddErrorsOf<false>(input, block, x, y);
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {

HWY_EXPORT(AddErrors);

void AddEdgeErrors(const KernelInput& input, const LaneBlock& block, AlikeEdges& x, AlikeEdges& y) {
  HWY_DYNAMIC_DISPATCH(AddErrors)(input, block, x, y);
}

}  // namespace chequer
#endif  // HWY_ONCE
