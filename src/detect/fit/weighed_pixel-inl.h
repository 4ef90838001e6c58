// What a pixel counts in the photometric kernels.
//
// Who includes this is compiled once for each target of the processor, so this file is included once a target, too: the
// guard turns with Highway's own.
#if defined(CHEQUER_DETECT_WEIGHED_PIXEL) == defined(HWY_TARGET_TOGGLE)
#ifdef CHEQUER_DETECT_WEIGHED_PIXEL
#undef CHEQUER_DETECT_WEIGHED_PIXEL
#else
#define CHEQUER_DETECT_WEIGHED_PIXEL
#endif

#include <hwy/highway.h>

#include "detect/fit/blurred_edge-inl.h"
#include "detect/fit/saturated_pixel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {

/// What a pixel counts.
struct Weighed {
  V root;       ///< of its weight, so that rows carry it
  V deviation;  ///< the residual times that
  V robust;     ///< its weight over that of its noise
  V saturated;  ///< of a saturated pixel, the same before it was found to be far off
  /// Of pixels that fit, by which noise is estimated: a few outliers would dominate it.
  V fits, fit_residual;
};

/// @param light of the model. @param per_deviation over the standard deviation of the noise there.
/// @param marked_light of the pixel, negated where it is saturated. @param inside whether there is a pixel.
/// @param limit deviations beyond which a pixel counts less.
template <class M>
HWY_INLINE Weighed WeighLight(V light, V per_deviation, V marked_light, M inside, V limit) {
  const D d;
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const V residual = hn::IfThenElseZero(inside, hn::Sub(hn::Abs(marked_light), light));
  Weighed w;
  w.root = hn::IfThenElseZero(inside, per_deviation);
  w.deviation = hn::Mul(residual, w.root);
  w.robust = w.fits = hn::IfThenElseZero(inside, one), w.fit_residual = residual, w.saturated = zero;
  const auto marked = hn::Lt(marked_light, zero);
  if (HWY_UNLIKELY(!hn::AllFalse(d, marked))) {
    const auto saturated = hn::And(marked, inside);
    const SaturatedPixel pixel = SaturatedAt(d, hn::Neg(w.deviation));
    const V root = hn::Sqrt(pixel.weight);
    w.root = hn::IfThenElse(saturated, hn::Mul(w.root, root), w.root);
    w.deviation = hn::IfThenElse(saturated, hn::Mul(pixel.deviation, root), w.deviation);
    w.robust = hn::IfThenElse(saturated, pixel.weight, w.robust);
    w.saturated = hn::IfThenElseZero(saturated, pixel.weight);
    w.fits = hn::IfThenElse(saturated, zero, w.fits);
    w.fit_residual = hn::IfThenElse(saturated, zero, w.fit_residual);
  }
  // Huber: beyond the limit the weight falls as 1 / deviation.
  const auto off = hn::Gt(hn::Abs(w.deviation), limit);
  if (HWY_UNLIKELY(!hn::AllFalse(d, off))) {
    const V share = hn::IfThenElse(off, hn::Div(limit, hn::Abs(w.deviation)), one), root = hn::Sqrt(share);
    w.robust = hn::Mul(w.robust, share);
    w.root = hn::Mul(w.root, root);
    w.deviation = hn::Mul(w.deviation, root);
    w.fits = hn::IfThenElse(off, zero, w.fits);
    w.fit_residual = hn::IfThenElse(off, zero, w.fit_residual);
  }
  return w;
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#endif  // CHEQUER_DETECT_WEIGHED_PIXEL
