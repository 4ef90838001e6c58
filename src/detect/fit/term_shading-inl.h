// Shading: light that falls off linearly over the board. Where no other term changes the light, shading.h finds it by
// the levels of cells instead. A shadow or a lamp's image changes these levels too; there the light within cells tells
// the shading. The lens blurs the product of shading E and board M to E M + ∇EᵀC∇M, C the covariance of its blur.
#ifndef CHEQUER_DETECT_TERM_SHADING
#define CHEQUER_DETECT_TERM_SHADING

#include <algorithm>

#include "detect/fit/term.h"

namespace chequer {

struct ShadingTerm {
  static constexpr int kColumns = 2;  ///< by which the light grows a cell along x and y, over that at the middle
  enum Lane { kBlurXx, kBlurXy, kBlurYy, kLanes };  ///< covariance of its blur, cells²
  struct Input {
    float grows_x = 0, grows_y = 0;
  };

  bool shaded = false;
  Eigen::Vector2d grows = Eigen::Vector2d::Zero();

  bool on() const { return shaded; }

  double At(const Eigen::Vector2d& board) const {
    constexpr double kLeast = 0.05;  // levels are divided by it
    return std::max(1 + grows.dot(board), kLeast);
  }

  void LightAt(const Eigen::Vector2d& board, LightThere& light) const { light.share *= At(board); }

  void SetInput(double /*blur_px*/, bool /*roughly*/, Input& input) const {
    input = {static_cast<float>(grows.x()), static_cast<float>(grows.y())};
  }

  template <class Set>
  void SetLanes(const Input& /*input*/, const TermCorner& corner, const Set& set) const {
    set(kBlurXx, corner.shading(0, 0));
    set(kBlurXy, corner.shading(0, 1));
    set(kBlurYy, corner.shading(1, 1));
  }

  template <class Vector>
  void AddPrior(Vector information, Vector pull) const {
    // A standard deviation, measured: with .03, of boards whose light falls off by up to .1 a cell under a lamp's image
    // in haze, 3 in 100 are off by more than they say instead of .4; with .08, poses under lamps alone are worse.
    constexpr double kKnownTo = 0.05;
    SetPrior<Eigen::Vector2d>(Eigen::Vector2d::Constant(kKnownTo), -grows, information, pull);
  }

  double Move(const TermStep& step) {
    // Longer steps lead elsewhere; then what no longer counts.
    const Eigen::Vector2d most(0.1, 0.1), still(0.001, 0.001), before = grows;
    grows += step.As<Eigen::Vector2d>().cwiseMax(-most).cwiseMin(most);
    return step.Make<Eigen::Vector2d>(grows - before, still);
  }
};

}  // namespace chequer

#endif  // CHEQUER_DETECT_TERM_SHADING

#ifdef CHEQUER_TERMS_ON_LANES

template <>
struct OnLanes<ShadingTerm> {
  static HWY_INLINE V Bend(const ShadingTerm::Input& s, const LaneModel& m, V x, V y, const PowerTerms& /*gaussian*/,
                           Picture& p, V* by) {
    const V xx = m.of<ShadingTerm>(ShadingTerm::kBlurXx), xy = m.of<ShadingTerm>(ShadingTerm::kBlurXy),
            yy = m.of<ShadingTerm>(ShadingTerm::kBlurYy);
    const V grows_x = Splat(s.grows_x), grows_y = Splat(s.grows_y);
    const V light = hn::MulAdd(grows_x, x, hn::MulAdd(grows_y, y, Splat(1)));
    by[0] = hn::MulAdd(x, p.light, hn::MulAdd(xx, p.by_x, hn::Mul(xy, p.by_y)));
    by[1] = hn::MulAdd(y, p.light, hn::MulAdd(xy, p.by_x, hn::Mul(yy, p.by_y)));
    // The light stays where it is on the board, which moves under the pixels.
    const V even = p.light;
    p.light = hn::MulAdd(grows_x, by[0], hn::MulAdd(grows_y, by[1], even));
    p.by_x = hn::MulAdd(light, p.by_x, hn::Mul(grows_x, even));
    p.by_y = hn::MulAdd(light, p.by_y, hn::Mul(grows_y, even));
    return light;
  }
};

#endif  // CHEQUER_TERMS_ON_LANES
