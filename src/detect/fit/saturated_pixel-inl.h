// What a saturated pixel tells, for the photometric kernels.
//
// Who includes this is compiled once for each target of the processor, so this file is included once a target, too: the
// guard turns with Highway's own.
#if defined(CHEQUER_DETECT_SATURATED_PIXEL) == defined(HWY_TARGET_TOGGLE)
#ifdef CHEQUER_DETECT_SATURATED_PIXEL
#undef CHEQUER_DETECT_SATURATED_PIXEL
#else
#define CHEQUER_DETECT_SATURATED_PIXEL
#endif

#include <hwy/highway.h>

#include "detect/common/reciprocal-inl.h"
#include "detect/fit/blurred_edge-inl.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {

/// A step of Gauss-Newton has a saturated pixel as one of that residual, in standard deviations of its noise, and of
/// that weight, over that of a pixel which is not saturated.
struct SaturatedPixel {
  V deviation, weight;
};

/// A saturated pixel tells that its light, with its noise, is full scale or more: a censored observation, of
/// log-likelihood log Φ(above) (Tobin, "Estimation of relationships for limited dependent variables", Econometrica
/// 1958). With λ = φ(above) / Φ(above), its score is λ and its information λ (λ + above).
/// @param above how far the model lies above full scale, standard deviations.
HWY_INLINE SaturatedPixel SaturatedAt(D d, V above) {
  // Far below full scale both φ and Φ vanish. Laplace's continued fraction replaces their ratio there:
  // λ + above = 1 / (t + 2 / (t + 3 / (t + 4 / (t + …)))) with t = −above. The constant 1.3 stands for its tail, which
  // it is at t = 2.5. The result is right to 0.1 % for all larger t.
  const auto far_below = hn::Lt(above, hn::Set(d, -2.5f));
  V far_sum = hn::Set(d, 1.3f);
  for (const float term : {4.0f, 3.0f, 2.0f, 1.0f}) far_sum = hn::Div(hn::Set(d, term), hn::Sub(far_sum, above));
  const Normal normal = NormalAt(d, hn::Mul(above, hn::Set(d, kUnit)), PowerTermsOf({}));
  const V near_score = hn::Div(hn::Mul(normal.density, hn::Set(d, kDensity)), normal.integral);
  const V score = hn::IfThenElse(far_below, hn::Sub(far_sum, above), near_score);
  const V sum = hn::IfThenElse(far_below, far_sum, hn::Add(near_score, above));
  return {hn::Div(hn::Set(d, 1.0f), sum), hn::Mul(score, sum)};
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#endif  // CHEQUER_DETECT_SATURATED_PIXEL
