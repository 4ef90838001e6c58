// The photometric model at the pixels of a vector of lanes, and what each of them counts.
//
// Who includes this is compiled once for each target of the processor, so this file is included once a target, too: the
// guard turns with Highway's own.
#if defined(CHEQUER_DETECT_PLAIN_LIGHT) == defined(HWY_TARGET_TOGGLE)
#ifdef CHEQUER_DETECT_PLAIN_LIGHT
#undef CHEQUER_DETECT_PLAIN_LIGHT
#else
#define CHEQUER_DETECT_PLAIN_LIGHT
#endif

#include <hwy/highway.h>

#include "detect/common/reciprocal-inl.h"
#include "detect/fit/blurred_edge-inl.h"
#include "detect/fit/photometric_kernel.h"
#include "detect/fit/weighed_pixel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {

/// What the kernel's input says of all lanes.
struct Shared {
  V board_from_plane[9];
  V per_blur, px;
  PowerTerms edge_x, edge_y;
  /// What the correlation changes by near the corner.
  struct {
    V square, product, fall;
    V moved_x, moved_y, moved_product;
    V moved_between;  ///< where both distances are none
    bool none;
  } corner;
  V narrower_x, narrower_y;
  bool narrows;
  V limit;
};

inline Shared SharedOf(const KernelInput& input) {
  const D d;
  Shared s;
  for (int i = 0; i < 9; ++i) s.board_from_plane[i] = hn::Set(d, input.board_from_plane[i]);
  s.per_blur = hn::Set(d, kUnit / input.blur_px);
  s.px = hn::Set(d, input.blur_px / kUnit);
  s.edge_x = PowerTermsOf(input.edge_x);
  s.edge_y = PowerTermsOf(input.edge_y);
  constexpr float kPerSquare = 1 / (kUnit * kUnit), kOfExcess = kDensity * kDensity * kPerSquare;
  s.corner.square = hn::Set(d, kOfExcess * input.corner.square);
  s.corner.product = hn::Set(d, kOfExcess * input.corner.product);
  s.corner.fall = hn::Set(d, kPerSquare * CornerExcess::kFall);
  s.corner.moved_x = hn::Set(d, kOfExcess * input.corner.moved_x);
  s.corner.moved_y = hn::Set(d, kOfExcess * input.corner.moved_y);
  s.corner.moved_product = hn::Set(d, kOfExcess * input.corner.moved_product);
  s.corner.moved_between = hn::Set(d, -kDensity * kDensity * (input.corner.moved_x + input.corner.moved_y));
  s.corner.none = input.corner.none();
  s.narrower_x = hn::Set(d, input.narrower_x / kUnit);
  s.narrower_y = hn::Set(d, input.narrower_y / kUnit);
  s.narrows = input.narrower_x != 0 || input.narrower_y != 0;
  s.limit = hn::Set(d, input.robust_limit);
  return s;
}

/// The same, with what it says of some lanes.
struct Model {
  explicit Model(const Shared& of_all) : shared(of_all) {}

  const Shared& shared;
  /// From the plane, as homogeneous coordinates: the distances from the two edges.
  V to_x[3], to_y[3];
  /// l00, its change from above to below at the left, from left to right above, and that by y.
  struct {
    V l00, down, across, cross, middle;
  } light;
  V correlation;  ///< with the densities' middles
  V noise_floor, noise_slope;
  /// Root of a pixel's weight, by the distances.
  struct {
    V x, y, middle_x, middle_y, peak_x, peak_y;
    bool any;  ///< the window of some lane fades
  } fade;
  /// By which edges move, in units of the distances from them, and its sign (LaneBlock::kGain).
  struct {
    V x, y, sign;
  } gain;
  V count;  ///< pixels
};

inline Model ModelOf(const Shared& shared, const LaneBlock& block, int first) {
  const D d;
  const auto parameter = [&](LaneBlock::Parameter which)
                             HWY_ATTR { return hn::LoadU(d, block.parameter_data(which) + first); };
  Model m(shared);
  const V scale_x = hn::Mul(parameter(LaneBlock::kPxPerCellX), shared.per_blur),
          scale_y = hn::Mul(parameter(LaneBlock::kPxPerCellY), shared.per_blur);
  const V corner_x = parameter(LaneBlock::kCornerX), corner_y = parameter(LaneBlock::kCornerY);
  for (int i = 0; i < 3; ++i) {
    const V* h = shared.board_from_plane + i;
    m.to_x[i] = hn::Mul(hn::NegMulAdd(corner_x, h[6], h[0]), scale_x);
    m.to_y[i] = hn::Mul(hn::NegMulAdd(corner_y, h[6], h[3]), scale_y);
  }
  m.correlation = hn::Mul(parameter(LaneBlock::kCorrelation), hn::Set(d, kDensity * kDensity));
  const V l10 = parameter(LaneBlock::kL10), l01 = parameter(LaneBlock::kL01), l11 = parameter(LaneBlock::kL11);
  m.light.l00 = parameter(LaneBlock::kL00);
  m.light.down = hn::Sub(l01, m.light.l00);
  m.light.across = hn::Sub(l10, m.light.l00);
  m.light.cross = hn::Sub(hn::Sub(l11, l01), m.light.across);
  m.noise_floor = parameter(LaneBlock::kNoiseFloor);
  m.noise_slope = parameter(LaneBlock::kNoiseSlope);
  m.light.middle = hn::Mul(hn::Add(hn::Add(m.light.l00, l11), hn::Add(l10, l01)), hn::Set(d, 0.25f));
  const V fade_x = parameter(LaneBlock::kFadeX), fade_y = parameter(LaneBlock::kFadeY);
  m.fade.x = hn::Div(fade_x, scale_x);
  m.fade.y = hn::Div(fade_y, scale_y);
  m.fade.middle_x = hn::Mul(parameter(LaneBlock::kMiddleX), scale_x);
  m.fade.middle_y = hn::Mul(parameter(LaneBlock::kMiddleY), scale_y);
  m.fade.peak_x = parameter(LaneBlock::kPeakX);
  m.fade.peak_y = parameter(LaneBlock::kPeakY);
  m.fade.any = !hn::AllTrue(d, hn::Eq(hn::Or(fade_x, fade_y), hn::Zero(d)));
  const V gain = parameter(LaneBlock::kGain);
  m.gain = {hn::Mul(gain, scale_x), hn::Mul(gain, scale_y), hn::CopySign(hn::Set(d, 1.0f), gain)};
  const hn::RebindToSigned<D> di;
  m.count = hn::ConvertTo(d, hn::LoadU(di, block.counts() + first));
  return m;
}

/// How far a chunk's pixels lie from the two edges, and the normal distribution there. The model is found in
/// short loops over the chunk: the processor then has the steps of many pixels at hand, none of which wait for each
/// other.
struct EdgeRow {
  enum {
    kX,
    kY,
    kDensityX,
    kDensityY,
    kIntegralX,
    kIntegralY,
    kValues,
    /// Where cells grow, each edge has two places: those before are the means of both, these half the difference.
    kDensityApartX = kValues,
    kDensityApartY,
    kIntegralApartX,
    kIntegralApartY,
    kValuesGrown
  };
};

HWY_INLINE void PlaceAtEdges(const Model& m, V u, V v, float* HWY_RESTRICT row) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto row_of = [&](const V* to) HWY_ATTR { return hn::MulAdd(to[0], u, hn::MulAdd(to[1], v, to[2])); };
  const V w = Reciprocal(d, row_of(m.shared.board_from_plane + 6));
  V x = hn::Mul(row_of(m.to_x), w), y = hn::Mul(row_of(m.to_y), w);
  if (m.shared.narrows) {
    const V product = hn::Mul(x, y);
    x = hn::MulAdd(m.shared.narrower_x, product, x);
    y = hn::MulAdd(m.shared.narrower_y, product, y);
  }
  hn::Store(x, d, row + EdgeRow::kX * lanes);
  hn::Store(y, d, row + EdgeRow::kY * lanes);
}

/// @tparam kGrown KernelInput::grown.
template <bool kGrown>
HWY_INLINE void BlurEdges(const Model& m, float* HWY_RESTRICT row) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int axis = 0; axis < 2; ++axis) {
    const V at = hn::Load(d, row + axis * lanes);
    const PowerTerms& edge = axis == 0 ? m.shared.edge_x : m.shared.edge_y;
    const auto put = [&](int which, V value) HWY_ATTR { hn::Store(value, d, row + (which + axis) * lanes); };
    if constexpr (kGrown) {
      const V gain = axis == 0 ? m.gain.x : m.gain.y, half = hn::Set(d, 0.5f);
      const Normal sooner = NormalAt(d, hn::Add(at, gain), edge), later = NormalAt(d, hn::Sub(at, gain), edge);
      put(EdgeRow::kDensityX, hn::Mul(half, hn::Add(sooner.density, later.density)));
      put(EdgeRow::kIntegralX, hn::Mul(half, hn::Add(sooner.integral, later.integral)));
      put(EdgeRow::kDensityApartX, hn::Mul(half, hn::Sub(sooner.density, later.density)));
      put(EdgeRow::kIntegralApartX, hn::Mul(half, hn::Sub(sooner.integral, later.integral)));
    } else {
      const Normal normal = NormalAt(d, at, edge);
      put(EdgeRow::kDensityX, normal.density);
      put(EdgeRow::kIntegralX, normal.integral);
    }
  }
}

/// The light of a pixel, and the shares of it to the right of one edge, below the other edge, and both.
struct Predicted {
  V light, right, down, both;
  V ax, ay, by_ax, by_ay;  ///< the distances from the edges, and derivatives by these
  V by_skew;               ///< and by the blur's correlation
  V by_blur_x, by_blur_y;  ///< and by the blur across each kind of edge, less what all pixels share
};

/// Of cells that grow: what the light changes by with the two places of an edge, their mean and half of what they
/// differ by.
struct ByPlaces {
  V mean, apart;
};

/// Sets the shares, where cells grow. Each of two that do has half of where they meet.
/// @param apart_x, apart_y half of what the shares differ by.
HWY_INLINE void Grow(const Model& m, V apart_x, V apart_y, Predicted& p, ByPlaces& x, ByPlaces& y) {
  const D d;
  const V one = hn::Set(d, 1.0f), right = p.right, down = p.down;
  const V twice_right = hn::Add(right, right), twice_down = hn::Add(down, down);
  const V more_right = hn::Add(right, apart_x), more_down = hn::Add(down, apart_y);
  const V less_right = hn::NegMulAdd(m.gain.sign, apart_x, right),
          less_down = hn::NegMulAdd(m.gain.sign, apart_y, down);
  const auto& light = m.light;
  const V twice_x = hn::Add(apart_x, apart_x), twice_y = hn::Add(apart_y, apart_y);
  x.mean = hn::MulAdd(light.cross, more_down, hn::MulAdd(light.down, twice_y, light.across));
  y.mean = hn::MulAdd(light.cross, more_right, hn::MulAdd(light.across, twice_x, light.down));
  x.apart = hn::MulAdd(light.cross, less_down, hn::Mul(light.across, hn::Sub(twice_down, one)));
  y.apart = hn::MulAdd(light.cross, less_right, hn::Mul(light.down, hn::Sub(twice_right, one)));
  p.both = hn::MulAdd(right, more_down, hn::Mul(apart_x, less_down));
  p.right = hn::MulAdd(apart_x, hn::Sub(twice_down, one), right);
  p.down = hn::MulAdd(apart_y, hn::Sub(twice_right, one), down);
}

/// Of the blur, with what else a corner has, so far from it.
HWY_INLINE V CorrelationAt(const Model& m, V ax, V ay) {
  const D d;
  V correlation = m.correlation;
  if (!m.shared.corner.none) {
    const auto& corner = m.shared.corner;
    const V ax_square = hn::Mul(ax, ax), ay_square = hn::Mul(ay, ay), product = hn::Mul(ax, ay);
    const V fall = hn::NegMulAdd(corner.fall, hn::Add(ax_square, ay_square), hn::Set(d, 1.0f));
    const V square = hn::Mul(corner.square, hn::Sub(ax_square, ay_square));
    correlation = hn::MulAdd(hn::MulAdd(corner.product, product, square), fall, correlation);
    const V moved = hn::MulAdd(corner.moved_x, ax_square, hn::MulAdd(corner.moved_y, ay_square, corner.moved_between));
    correlation = hn::Add(correlation, hn::MulAdd(corner.moved_product, product, moved));
  }
  return correlation;
}

/// Edges that are not square to each other blur together: the shares are those of a bivariate normal distribution, to
/// first order in the correlation.
/// @tparam kGrown KernelInput::grown.
template <bool kGrown>
HWY_INLINE Predicted Predict(const Model& m, const float* HWY_RESTRICT edges) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto of = [&](int which) HWY_ATTR { return hn::Load(d, edges + which * lanes); };
  Predicted p;
  p.ax = of(EdgeRow::kX), p.ay = of(EdgeRow::kY), p.right = of(EdgeRow::kIntegralX), p.down = of(EdgeRow::kIntegralY);
  const V density_x = of(EdgeRow::kDensityX), density_y = of(EdgeRow::kDensityY);
  const auto& light = m.light;
  if constexpr (kGrown) {
    // Where two cells grow into one, their corner becomes two, which lie across the others' diagonal.
    const V apart_x = of(EdgeRow::kDensityApartX), apart_y = of(EdgeRow::kDensityApartY);
    const V to_x = m.gain.x, to_y = hn::Mul(m.gain.sign, m.gain.y), signed_y = hn::Mul(m.gain.sign, apart_y);
    const V one_densities = hn::Mul(hn::Sub(density_x, apart_x), hn::Add(density_y, signed_y)),
            other_densities = hn::Mul(hn::Add(density_x, apart_x), hn::Sub(density_y, signed_y));
    const V half = hn::Set(d, 0.5f);
    const V one = hn::Mul(half, hn::Mul(CorrelationAt(m, hn::Sub(p.ax, to_x), hn::Add(p.ay, to_y)), one_densities)),
            other = hn::Mul(half, hn::Mul(CorrelationAt(m, hn::Add(p.ax, to_x), hn::Sub(p.ay, to_y)), other_densities));
    const V twist = hn::Add(one, other), across = hn::Sub(other, one);
    ByPlaces x, y;
    Grow(m, of(EdgeRow::kIntegralApartX), of(EdgeRow::kIntegralApartY), p, x, y);
    p.both = hn::Add(p.both, twist);
    p.light =
        hn::MulAdd(light.across, p.right, hn::MulAdd(light.down, p.down, hn::MulAdd(light.cross, p.both, light.l00)));
    const V change = hn::Mul(light.cross, hn::Set(d, 1 / (kUnit * kDensity)));
    const V twist_x = hn::MulAdd(p.ax, twist, hn::Mul(to_x, across)),
            twist_y = hn::NegMulAdd(to_y, across, hn::Mul(p.ay, twist));
    p.by_ax = hn::NegMulAdd(twist_x, change, hn::MulAdd(x.mean, density_x, hn::Mul(x.apart, apart_x)));
    p.by_ay = hn::NegMulAdd(twist_y, change, hn::MulAdd(y.mean, density_y, hn::Mul(y.apart, apart_y)));
    // A wider blur changes the light at both places, by their distances.
    const V by_gain_x = hn::MulAdd(x.mean, apart_x, hn::Mul(x.apart, density_x)),
            by_gain_y = hn::MulAdd(y.mean, apart_y, hn::Mul(y.apart, density_y));
    p.by_blur_x = hn::MulAdd(p.by_ax, p.ax, hn::Mul(by_gain_x, m.gain.x));
    p.by_blur_y = hn::MulAdd(p.by_ay, p.ay, hn::Mul(by_gain_y, m.gain.y));
    p.by_skew = hn::Mul(light.cross, hn::Mul(half, hn::Add(one_densities, other_densities)));
  } else {
    const V densities = hn::Mul(density_x, density_y), twist = hn::Mul(CorrelationAt(m, p.ax, p.ay), densities);
    const V slope_x = hn::MulAdd(light.cross, p.down, light.across),
            slope_y = hn::MulAdd(light.cross, p.right, light.down);
    const V twist_slope = hn::Mul(light.cross, twist);
    p.light = hn::Add(hn::MulAdd(slope_y, p.down, hn::MulAdd(light.across, p.right, light.l00)), twist_slope);
    p.both = hn::MulAdd(p.right, p.down, twist);
    const V twist_change = hn::Mul(twist_slope, hn::Set(d, 1 / (kUnit * kDensity)));
    p.by_ax = hn::NegMulAdd(p.ax, twist_change, hn::Mul(slope_x, density_x));
    p.by_ay = hn::NegMulAdd(p.ay, twist_change, hn::Mul(slope_y, density_y));
    p.by_blur_x = hn::Mul(p.by_ax, p.ax);
    p.by_blur_y = hn::Mul(p.by_ay, p.ay);
    p.by_skew = hn::Mul(light.cross, densities);
  }
  return p;
}

template <class M>
HWY_INLINE Weighed Weigh(const Model& m, const Predicted& p, V marked_light, M inside) {
  const D d;
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  // The window ends softly, and moves with the board: which pixels count does not depend on where a fit began.
  V window = one;
  if (m.fade.any) {
    window = hn::Min(hn::NegMulAdd(hn::Abs(hn::Sub(p.ax, m.fade.middle_x)), m.fade.x, m.fade.peak_x),
                     hn::NegMulAdd(hn::Abs(hn::Sub(p.ay, m.fade.middle_y)), m.fade.y, m.fade.peak_y));
    window = hn::Max(hn::Min(window, one), zero);
    inside = hn::And(inside, hn::Gt(window, zero));
  }
  const V variance = hn::MulAdd(m.noise_slope, hn::Max(p.light, zero), m.noise_floor);
  Weighed w = WeighLight(p.light, RoughReciprocalSqrt(d, variance), marked_light, inside, m.shared.limit);
  if (m.fade.any) {
    w.root = hn::Mul(w.root, window);
    w.deviation = hn::Mul(w.deviation, window);
    w.robust = hn::Mul(w.robust, hn::Mul(window, window));
  }
  return w;
}

/// The most pixels of a lane in the vector from `first` on.
HWY_INLINE int MostOf(const LaneBlock& block, int first) {
  const hn::RebindToSigned<D> di;
  return hn::GetLane(hn::MaxOfLanes(di, hn::LoadU(di, block.counts() + first)));
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#endif  // CHEQUER_DETECT_PLAIN_LIGHT
