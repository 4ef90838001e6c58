// Uneven blur: wider along one direction than across it, by which motion is found, as a short way blurs so. It is never
// fitted; one step to it tells.
#ifndef CHEQUER_DETECT_TERM_UNEVEN_BLUR
#define CHEQUER_DETECT_TERM_UNEVEN_BLUR

#include "detect/fit/term.h"

namespace chequer {

struct UnevenBlurTerm {
  static constexpr int kColumns = 2;  ///< half of what its variances along x and y differ by, and their covariance, px²
  static constexpr int kLanes = 0;
  struct Input {};

  bool on() const { return false; }
  double Move(const TermStep& /*step*/) { return 0; }
};

}  // namespace chequer

#endif  // CHEQUER_DETECT_TERM_UNEVEN_BLUR

#ifdef CHEQUER_TERMS_ON_LANES

template <>
struct OnLanes<UnevenBlurTerm> {
  static HWY_INLINE void Derive(const LaneModel& m, V /*x*/, V /*y*/, const Picture& p, V* by) {
    // A blur's variance moves the light by half of its second derivative: here by those along the image's x and y.
    const auto second = [&](V x1, V y1, V x2, V y2) HWY_ATTR {
      const V mixed = hn::MulAdd(x1, y2, hn::Mul(y1, x2));
      return hn::MulAdd(hn::Mul(x1, x2), p.by_xx, hn::MulAdd(mixed, p.by_xy, hn::Mul(hn::Mul(y1, y2), p.by_yy)));
    };
    const V xx = m.of(ModelLanes::kByPixelXx), xy = m.of(ModelLanes::kByPixelXy), yx = m.of(ModelLanes::kByPixelYx),
            yy = m.of(ModelLanes::kByPixelYy);
    by[0] = hn::Mul(Splat(0.5f), hn::Sub(second(xx, yx, xx, yx), second(xy, yy, xy, yy)));
    by[1] = second(xx, yx, xy, yy);
  }
};

#endif  // CHEQUER_TERMS_ON_LANES
