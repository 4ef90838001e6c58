// Edges as a lens blurs them, for the photometric kernel.
//
// The kernel includes itself once for each target of the processor, so this file is included once a target, too: the
// guard turns with Highway's own.
#if defined(CHEQUER_DETECT_BLURRED_EDGE) == defined(HWY_TARGET_TOGGLE)
#ifdef CHEQUER_DETECT_BLURRED_EDGE
#undef CHEQUER_DETECT_BLURRED_EDGE
#else
#define CHEQUER_DETECT_BLURRED_EDGE
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "detect/fit/photometric_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

/// 2^−x for 0 ≤ x ≤ 60, to 8e-5 of it: the exponent's bits times a polynomial of the rest, best over −½..½.
HWY_INLINE V TwoToMinus(D d, V x) {
  // So large a number has no room for halves: its last bits are the whole of −x and the exponent's bias.
  const V rounder = hn::Set(d, 12582912.0f + 127.0f);
  const V rounded = hn::Sub(rounder, x);
  const V f = hn::Add(x, hn::Sub(rounded, rounder));
  const hn::RebindToSigned<D> di;
  V p = hn::MulAdd(hn::Set(d, -5.51717e-2f), f, hn::Set(d, 2.4261163e-1f));
  p = hn::MulAdd(p, f, hn::Set(d, -6.9326102e-1f));
  p = hn::MulAdd(p, f, hn::Set(d, 9.9992804e-1f));
  return hn::Mul(p, hn::BitCast(d, hn::ShiftLeft<23>(hn::BitCast(di, rounded))));
}

// Distances from edges are in standard deviations of the blur times kUnit, so that a Gaussian is 2^(−distance²). What
// that and the other constants do to the derivatives is put right in the sums, once a lane instead of once a pixel.
constexpr float kUnit = 0.84932180f;     ///< √(log₂(e) / 2)
constexpr float kDensity = 0.39894228f;  ///< of the normal distribution, in the middle

/// Normal distribution: its density, over that in the middle, and its integral up to a.
struct Normal {
  V density, integral;
};

/// EdgeTerms, for vectors.
struct PowerTerms {
  V by_power[EdgeTerms::kTerms];
};

HWY_INLINE PowerTerms PowerTermsOf(const EdgeTerms& edge) {
  const D d;
  PowerTerms terms;
  float unit = 1;
  for (int i = 0; i < EdgeTerms::kTerms; ++i) {
    unit *= 1 / kUnit;
    terms.by_power[i] = hn::Set(d, unit * edge.by_power[static_cast<std::size_t>(i)]);
  }
  return terms;
}

/// What is left of an edge farther off is constant, 3e-7 of its contrast: 5 deviations.
constexpr float kFarthestNormal = 5.0f * kUnit;

/// What lies beyond |a| is the exponential times a polynomial, good over 0..5 deviations, its terms summed so that few
/// wait for others.
HWY_INLINE Normal NormalAt(D d, V a, const PowerTerms& edge) {
  const V size = hn::Min(hn::Abs(a), hn::Set(d, kFarthestNormal)), square = hn::Mul(size, size);
  const V e = TwoToMinus(d, square);
  const V* by = edge.by_power;
  V p = hn::MulAdd(by[5], square, hn::MulAdd(by[4], size, by[3]));
  p = hn::MulAdd(p, square, hn::MulAdd(by[2], size, by[1]));
  p = hn::MulAdd(p, square, hn::MulAdd(by[0], size, hn::Set(d, 4.9998433e-1f)));
  const V beyond = hn::Mul(p, e);
  return {e, hn::IfNegativeThenElse(a, beyond, hn::Sub(hn::Set(d, 1.0f), beyond))};
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#endif  // CHEQUER_DETECT_BLURRED_EDGE
