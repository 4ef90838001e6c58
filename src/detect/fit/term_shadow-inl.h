// A shadow: its edge crosses the board, and the light E(x, y) falls on that. The lens blurs the product to
//   E M + ∇EᵀC∇M + ½ tr(C H_E C H_M),
// C the covariance of its blur (the Gaussian's product rule, to second order). So does a camera's motion, which takes
// light and board along; a board that moves through the light does not mix them: half of its way's covariance is added,
// as with shading (BoardFit::HowLightSpreads). shadow_edge.h has the edge, and finds where its fit starts.
#ifndef CHEQUER_DETECT_TERM_SHADOW
#define CHEQUER_DETECT_TERM_SHADOW

#include <optional>

#include "detect/fit/shadow_edge.h"
#include "detect/fit/term.h"

namespace chequer {

struct ShadowTerm {
  static constexpr int kColumns = ShadowEdge::kParameters;  ///< as ShadowEdge::Parameter has them
  enum Lane { kMixedX, kMixedY, kLanes };  ///< the blur's covariance times the edge's direction, cells²
  struct Input {
    float takes = 0, normal_x = 1, normal_y = 0, offset = 0, per_width = 1;
  };

  std::optional<ShadowEdge> shadow;
  ShadowEdge::Parameters shadow_start = ShadowEdge::Parameters::Zero();

  bool on() const { return shadow.has_value(); }

  void Start(const ShadowEdge::Parameters& values) {
    shadow = ShadowEdge(values);
    shadow_start = shadow->values();
  }

  void SetInput(double /*blur_px*/, bool /*roughly*/, Input& input) const {
    const ShadowEdge::Parameters& values = shadow->values();
    const auto value = [](double of) { return static_cast<float>(of); };
    input = {value(values[ShadowEdge::kTakes]), value(std::cos(values[ShadowEdge::kDirection])),
             value(std::sin(values[ShadowEdge::kDirection])), value(values[ShadowEdge::kOffset]),
             value(std::exp(-values[ShadowEdge::kLogWidth]))};
  }

  template <class Set>
  void SetLanes(const Input& input, const TermCorner& corner, const Set& set) const {
    const Eigen::Vector2d mixed =
        (corner.lens + corner.way / 2) * Eigen::Vector2d(double{input.normal_x}, double{input.normal_y});
    set(kMixedX, mixed.x());
    set(kMixedY, mixed.y());
  }

  template <class Vector>
  void AddPrior(Vector information, Vector pull) const {
    // What is known of the edge before the pixels are looked at: standard deviations.
    const ShadowEdge::Parameters known_to(0.1, 0.3, 0.4, 0.8);
    SetPrior<ShadowEdge::Parameters>(known_to, shadow_start - shadow->values(), information, pull);
  }

  double Move(const TermStep& step) {
    // Longer steps lead elsewhere; then what no longer counts.
    const ShadowEdge::Parameters most(0.1, 0.3, 0.3, 0.5), still(0.003, 0.003, 0.004, 0.03), before = shadow->values();
    ShadowEdge::Parameters values = before + step.As<ShadowEdge::Parameters>().cwiseMax(-most).cwiseMin(most);
    // The edge is seen through the lens, which makes none sharper than its own blur.
    const Eigen::RowVector2d across(std::cos(values[ShadowEdge::kDirection]), std::sin(values[ShadowEdge::kDirection]));
    const double blur = step.blur_px * (across * step.board_by_pixel).norm();
    values[ShadowEdge::kLogWidth] = std::max(values[ShadowEdge::kLogWidth], std::log(blur));
    shadow = ShadowEdge(values);
    return step.Make<ShadowEdge::Parameters>(shadow->values() - before, still);
  }

  void LightAt(const Eigen::Vector2d& board, LightThere& light) const { light.share *= shadow->At(board); }
};

}  // namespace chequer

#endif  // CHEQUER_DETECT_TERM_SHADOW

#ifdef CHEQUER_TERMS_ON_LANES

template <>
struct OnLanes<ShadowTerm> {
  /// The light of the shadow that falls on it. @param x, y on the board. Writes the derivatives by the shadow.
  static HWY_INLINE V Bend(const ShadowTerm::Input& s, const LaneModel& m, V x, V y, const PowerTerms& gaussian,
                           Picture& p, V* by) {
    const D d;
    const V across = hn::Sub(hn::MulAdd(Splat(s.normal_x), x, hn::Mul(Splat(s.normal_y), y)), Splat(s.offset));
    const V a = hn::Mul(across, Splat(s.per_width));
    const Normal normal = NormalAt(d, hn::Mul(a, Splat(kUnit)), gaussian);
    const V takes = Splat(s.takes), density = hn::Mul(normal.density, Splat(kDensity * s.per_width));
    const V lit = hn::NegMulAdd(takes, normal.integral, Splat(1)), fall = hn::Mul(takes, density);
    // How the light of the board changes along what the blur mixes across the edge.
    const V qx = m.of<ShadowTerm>(ShadowTerm::kMixedX), qy = m.of<ShadowTerm>(ShadowTerm::kMixedY);
    const V mixed = hn::MulAdd(qx, p.by_x, hn::Mul(qy, p.by_y));
    const V twice =
        hn::MulAdd(hn::Mul(qx, qx), p.by_xx,
                   hn::MulAdd(hn::Mul(qy, qy), p.by_yy, hn::Mul(hn::Mul(Splat(2), hn::Mul(qx, qy)), p.by_xy)));
    const V bend = hn::Mul(hn::Mul(density, a), Splat(s.per_width));
    const V even = p.light;
    // E M − takes φ/w (q·∇M) + ½ takes a φ/w² (q·∇)² M: by the part of it that grows with the share taken.
    const V taken =
        hn::MulAdd(normal.integral, even, hn::MulAdd(density, mixed, hn::Mul(Splat(-0.5f), hn::Mul(bend, twice))));
    p.light = hn::NegMulAdd(takes, taken, even);
    by[0] = hn::Neg(taken);
    const V by_offset = hn::Mul(fall, hn::NegMulAdd(hn::Mul(a, Splat(s.per_width)), mixed, even));
    const V along = hn::NegMulAdd(Splat(s.normal_y), x, hn::Mul(Splat(s.normal_x), y));
    by[1] = hn::Neg(hn::Mul(by_offset, along));
    by[2] = by_offset;
    by[3] = hn::Mul(by_offset, across);
    // The edge stays where it is on the board, which moves under the pixels.
    p.by_x = hn::NegMulAdd(Splat(s.normal_x), by_offset, hn::Mul(lit, p.by_x));
    p.by_y = hn::NegMulAdd(Splat(s.normal_y), by_offset, hn::Mul(lit, p.by_y));
    return lit;
  }
};

#endif  // CHEQUER_TERMS_ON_LANES
