// Quick reciprocals for the files that are compiled once for each target of the processor.
//
// Such a file includes itself, so this one is included once a target, too: the guard turns with Highway's own.
#if defined(CHEQUER_DETECT_RECIPROCAL) == defined(HWY_TARGET_TOGGLE)
#ifdef CHEQUER_DETECT_RECIPROCAL
#undef CHEQUER_DETECT_RECIPROCAL
#else
#define CHEQUER_DETECT_RECIPROCAL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {

/// 1 / x: the hardware's estimate and a step of Newton's, to 1e-5 of it (from 12 good bits) at a third of a division's
/// cost.
template <class D>
HWY_INLINE hwy::HWY_NAMESPACE::Vec<D> Reciprocal(D d, hwy::HWY_NAMESPACE::Vec<D> x) {
  namespace hn = hwy::HWY_NAMESPACE;
  const auto estimate = hn::ApproximateReciprocal(x);
  return hn::Mul(estimate, hn::NegMulAdd(x, estimate, hn::Set(d, 2.0f)));
}

/// 1 / √x, likewise; exact where the target has no estimate of its own.
template <class D>
HWY_INLINE hwy::HWY_NAMESPACE::Vec<D> ReciprocalSqrt(D d, hwy::HWY_NAMESPACE::Vec<D> x) {
  namespace hn = hwy::HWY_NAMESPACE;
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128
  return hn::Div(hn::Set(d, 1.0f), hn::Sqrt(x));
#else
  const auto estimate = hn::ApproximateReciprocalSqrt(x);
  const auto half = hn::Mul(hn::Mul(x, hn::Set(d, 0.5f)), estimate);
  return hn::Mul(estimate, hn::NegMulAdd(half, estimate, hn::Set(d, 1.5f)));
#endif
}

/// The same where 4e-4 of it do not matter, as in weights: the estimate alone, if it is as good.
template <class D>
HWY_INLINE hwy::HWY_NAMESPACE::Vec<D> RoughReciprocalSqrt(D d, hwy::HWY_NAMESPACE::Vec<D> x) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  (void)d;
  return hwy::HWY_NAMESPACE::ApproximateReciprocalSqrt(x);
#else
  return ReciprocalSqrt(d, x);
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#endif  // CHEQUER_DETECT_RECIPROCAL
