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
void AddErrorsOf(const KernelInput& input, const LaneBlock& block, AlikeEdges& x, AlikeEdges& y, AlikePlaces* places) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Shared shared = SharedOf(input);
  HWY_ALIGN float edges[EdgeRow::kValuesGrown * EdgePixels::kMaxLanes];
  EdgesOfPixels pixels;
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
      pixels.x.Set(hn::Mul(p.ax, shared.px), hn::Mul(p.by_ax, w.root), w.deviation);
      pixels.y.Set(hn::Mul(p.ay, shared.px), hn::Mul(p.by_ay, w.root), w.deviation);
      pixels.Set(w.deviation, m.light.cross, w.robust);
      pixels.AddTo(x, y, places, first, lanes);
    }
  }
}

void AddErrors(const KernelInput& input, const LaneBlock& block, AlikeEdges& x, AlikeEdges& y, AlikePlaces* places) {
  input.grown ? AddErrorsOf<true>(input, block, x, y, places) : AddErrorsOf<false>(input, block, x, y, places);
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

/// Fewer pixels at one place tell nothing of what corners share.
constexpr float kFewestThere = 3;
/// What may be chance is left out; one board in 1,000 whose errors are noise has more (of a normal deviate).
constexpr double kDeviationsOfChance = 3;

}  // namespace

HWY_EXPORT(AddErrors);

void AddEdgeErrors(const KernelInput& input, const LaneBlock& block, AlikeEdges& x, AlikeEdges& y,
                   AlikePlaces* places) {
  HWY_DYNAMIC_DISPATCH(AddErrors)(input, block, x, y, places);
}

double AlikePlaces::Shared() const {
  double between = 0, squares = 0, pixels = 0, found = 0;
  for (const Errors& place : errors) {
    if (place.count < kFewestThere) continue;
    between += double{place.sum} * double{place.sum} / double{place.count};
    squares += double{place.square};
    pixels += double{place.count};
    ++found;
  }
  const double noise = std::max(squares - between, 0.0) / std::max(pixels - found, 1.0);
  // Chance makes a sum of squares of that many unknowns.
  const double of_chance = noise * (found + kDeviationsOfChance * std::sqrt(2 * found));
  return AlikeEdges::kStride * std::max(between - of_chance, 0.0);
}

}  // namespace chequer
#endif  // HWY_ONCE
