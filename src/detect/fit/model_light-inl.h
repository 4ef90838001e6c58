// The light of pixels around corners by the model with all its terms, and its derivatives, for the model's kernel.
//
// The kernel includes itself once for each target of the processor, so this file is included once a target, too: the
// guard turns with Highway's own.
#if defined(CHEQUER_DETECT_MODEL_LIGHT) == defined(HWY_TARGET_TOGGLE)
#ifdef CHEQUER_DETECT_MODEL_LIGHT
#undef CHEQUER_DETECT_MODEL_LIGHT
#else
#define CHEQUER_DETECT_MODEL_LIGHT
#endif

#include <hwy/highway.h>

#include "detect/fit/blurred_edge-inl.h"
#include "detect/fit/model_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Edges of cells that one axis crosses around a corner.
constexpr int kEdges = 3;
constexpr int kSide = 4;

HWY_INLINE V Splat(float value) { return hn::Set(D(), value); }

/// What lanes are given, loaded.
struct LaneModel {
  V to_x[3], to_y[3], to_depth[3];
  V value[ModelLanes::kLevel00];
  V light[kSide][kSide];
  /// The same by differences along both axes: the light of a sum of edges instead of cells.
  V step[kSide][kSide];
  bool skewed;  ///< some lane has a kSkew that is not 0

  HWY_INLINE V of(ModelLanes::Parameter which) const { return value[which]; }
};

void Load(const ModelInput& input, const ModelLanes& model, int first, LaneModel& m) {
  const D d;
  for (int i = 0; i < ModelLanes::kLevel00; ++i) m.value[i] = hn::LoadU(d, model.parameter_data(i) + first);
  m.skewed = !hn::AllTrue(d, hn::Eq(m.of(ModelLanes::kSkew), hn::Zero(d)));
  for (int i = 0; i < 3; ++i) {
    const float* h = input.board_from_plane + i;
    m.to_depth[i] = Splat(h[6]);
    m.to_x[i] = hn::NegMulAdd(m.of(ModelLanes::kCornerX), m.to_depth[i], Splat(h[0]));
    m.to_y[i] = hn::NegMulAdd(m.of(ModelLanes::kCornerY), m.to_depth[i], Splat(h[3]));
  }
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col)
      m.light[row][col] = hn::LoadU(d, model.parameter_data(ModelLanes::kLevel00 + kSide * row + col) + first);
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col) {
      V step = m.light[row][col];
      if (col > 0) step = hn::Sub(step, m.light[row][col - 1]);
      if (row > 0) step = hn::Sub(step, m.light[row - 1][col]);
      if (row > 0 && col > 0) step = hn::Add(step, m.light[row - 1][col - 1]);
      m.step[row][col] = step;
    }
}

/// Light and its derivatives at a pixel, the mean over the way's points.
struct Picture {
  V light, by_x, by_y, by_blur, by_gain, by_xy, by_xx, by_yy, way_x, way_y;
  V twist_by_both;  ///< of the light's derivative by x and y, that by both, in units of the blur's variances
  V share[kSide][kSide];

  HWY_INLINE void Clear() {
    const V zero = hn::Zero(D());
    light = by_x = by_y = by_blur = by_gain = by_xy = by_xx = by_yy = way_x = way_y = zero;
    twist_by_both = zero;
    for (auto& row : share)
      for (V& cell : row) cell = zero;
  }
};

/// Of the edges along one axis, what lies on their far side: its share, and the derivatives of that by the place
/// (cells), the second one in units of the blur's variance. That is what a wider blur changes, too.
struct EdgesAlong {
  V share[kEdges], slope[kEdges], bend[kEdges];
};

/// @param at distance from the middle edge, cells. @param shift by which each edge is moved down.
HWY_INLINE void BlurAlong(V at, const V* shift, V scale, const PowerTerms& terms, EdgesAlong& edges) {
  const D d;
  const V unit = hn::Mul(scale, Splat(kUnit)), density = hn::Mul(scale, Splat(kDensity));
  for (int k = 0; k < kEdges; ++k) {
    const V from = hn::Add(hn::Sub(at, Splat(static_cast<float>(k - 1))), shift[k]);
    const Normal normal = NormalAt(d, hn::Mul(from, unit), terms);
    edges.share[k] = normal.integral;
    edges.slope[k] = hn::Mul(normal.density, density);
    edges.bend[k] = hn::Neg(hn::Mul(from, edges.slope[k]));
  }
}

/// Σ_k row[k + 1] edge[k].
HWY_INLINE V AtEdges(const V* row, const V* edge) {
  return hn::MulAdd(row[1], edge[0], hn::MulAdd(row[2], edge[1], hn::Mul(row[3], edge[2])));
}

/// The shares of the four cells along an axis. @param all of them: 1; of the shares' derivatives, 0.
HWY_INLINE void SharesOf(V all, const V* edge, V* cells) {
  cells[0] = hn::Sub(all, edge[0]);
  cells[1] = hn::Sub(edge[0], edge[1]);
  cells[2] = hn::Sub(edge[1], edge[2]);
  cells[3] = edge[2];
}

/// By the second derivatives along x and y, in units of the blur's variances.
HWY_INLINE void AddBends(const LaneModel& m, V bend_x, V bend_y, Picture& p) {
  const V scale_x = m.of(ModelLanes::kScaleX), scale_y = m.of(ModelLanes::kScaleY);
  p.by_blur = hn::MulAdd(bend_x, m.of(ModelLanes::kBlurX), hn::MulAdd(bend_y, m.of(ModelLanes::kBlurY), p.by_blur));
  p.by_xx = hn::MulAdd(bend_x, hn::Mul(scale_x, scale_x), p.by_xx);
  p.by_yy = hn::MulAdd(bend_y, hn::Mul(scale_y, scale_y), p.by_yy);
}

/// The light's derivatives by the place at a point of the way, given those of a blur without covariance, and how they
/// change along both axes in units of the blur's variances.
HWY_INLINE void AddSlopes(const LaneModel& m, V part, V by_x, V by_y, V twist_by_x, V twist_by_y, Picture& p) {
  if (m.skewed) {
    const V skew = m.of(ModelLanes::kSkew), scale_x = m.of(ModelLanes::kScaleX), scale_y = m.of(ModelLanes::kScaleY);
    by_x = hn::MulAdd(hn::Mul(skew, hn::Mul(scale_x, scale_x)), twist_by_x, by_x);
    by_y = hn::MulAdd(hn::Mul(skew, hn::Mul(scale_y, scale_y)), twist_by_y, by_y);
  }
  p.by_x = hn::Add(p.by_x, by_x);
  p.by_y = hn::Add(p.by_y, by_y);
  p.way_x = hn::MulAdd(part, by_x, p.way_x);
  p.way_y = hn::MulAdd(part, by_y, p.way_y);
}

/// A point of the way, cells printed as they should be. @param part of the way, −½ … ½.
HWY_INLINE void AddPoint(const LaneModel& m, V x, V y, V part, const PowerTerms* terms, Picture& p) {
  EdgesAlong along, down;
  const V zero = hn::Zero(D()), none[kEdges] = {zero, zero, zero};
  BlurAlong(x, none, m.of(ModelLanes::kScaleX), terms[0], along);
  BlurAlong(y, none, m.of(ModelLanes::kScaleY), terms[1], down);
  V row[kSide], by_x[kSide], bend_x[kSide];
  for (int j = 0; j < kSide; ++j) {
    row[j] = hn::Add(m.step[j][0], AtEdges(m.step[j], along.share));
    by_x[j] = AtEdges(m.step[j], along.slope);
    bend_x[j] = AtEdges(m.step[j], along.bend);
  }
  const V light_by_x = hn::Add(by_x[0], AtEdges(by_x, down.share)), light_by_y = AtEdges(row, down.slope);
  p.light = hn::Add(p.light, hn::Add(row[0], AtEdges(row, down.share)));
  AddSlopes(m, part, light_by_x, light_by_y, AtEdges(bend_x, down.slope), AtEdges(by_x, down.bend), p);
  AddBends(m, hn::Add(bend_x[0], AtEdges(bend_x, down.share)), AtEdges(row, down.bend), p);
  p.by_xy = hn::Add(p.by_xy, AtEdges(by_x, down.slope));
  p.twist_by_both = hn::Add(p.twist_by_both, AtEdges(bend_x, down.bend));
  V cols[kSide], rows[kSide];
  SharesOf(Splat(1), along.share, cols);
  SharesOf(Splat(1), down.share, rows);
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) p.share[j][i] = hn::MulAdd(rows[j], cols[i], p.share[j][i]);
  if (!m.skewed) return;
  SharesOf(zero, along.slope, cols);
  SharesOf(zero, down.slope, rows);
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i)
      p.share[j][i] = hn::MulAdd(hn::Mul(m.of(ModelLanes::kSkew), rows[j]), cols[i], p.share[j][i]);
}

/// Along one axis, what cells that grow, cells that give way, and the overlaps at both of their ends have of a pixel.
struct GrownCells {
  V grown[kSide], given[kSide], overlap[kSide];
};

/// @param later, sooner of edges that are moved up and down.
HWY_INLINE void Grow(const V* sooner, const V* later, bool of_shares, GrownCells& cells) {
  const V zero = hn::Zero(D()), all = of_shares ? Splat(1) : zero;
  for (int i = 0; i < kSide; ++i) {
    const V from_sooner = i > 0 ? sooner[i - 1] : all, from_later = i > 0 ? later[i - 1] : all;
    const V to_sooner = i < kEdges ? sooner[i] : zero, to_later = i < kEdges ? later[i] : zero;
    cells.grown[i] = hn::Sub(from_sooner, to_later);
    cells.given[i] = hn::Sub(from_later, to_sooner);
    cells.overlap[i] = hn::Sub(hn::Add(from_sooner, to_sooner), hn::Add(from_later, to_later));
  }
}

/// Light by rows of cells, where the columns have these shares.
struct GrownRows {
  V grown[kSide], given[kSide], overlap[kSide];
};

HWY_INLINE void RowsOf(const LaneModel& m, const GrownCells& cols, GrownRows& rows) {
  const V half_even = m.of(ModelLanes::kHalfEven), half_odd = m.of(ModelLanes::kHalfOdd);
  for (int j = 0; j < kSide; ++j) {
    const V* light = m.light[j];
    const int even = j % 2, odd = 1 - even;  // columns
    rows.grown[j] = hn::MulAdd(light[even], cols.grown[even], hn::Mul(light[even + 2], cols.grown[even + 2]));
    rows.given[j] = hn::MulAdd(light[odd], cols.given[odd], hn::Mul(light[odd + 2], cols.given[odd + 2]));
    const V of_even = hn::MulAdd(light[even], cols.overlap[even], hn::Mul(light[even + 2], cols.overlap[even + 2]));
    const V of_odd = hn::MulAdd(light[odd], cols.overlap[odd], hn::Mul(light[odd + 2], cols.overlap[odd + 2]));
    rows.overlap[j] = hn::MulAdd(half_even, of_even, hn::Mul(half_odd, of_odd));
  }
}

HWY_INLINE V LightOf(const GrownRows& rows, const GrownCells& down) {
  V sum = hn::Zero(D());
  for (int j = 0; j < kSide; ++j) {
    sum = hn::MulAdd(rows.grown[j], down.grown[j], sum);
    sum = hn::MulAdd(rows.given[j], down.given[j], sum);
    sum = hn::NegMulAdd(rows.overlap[j], down.overlap[j], sum);
  }
  return sum;
}

/// The same of cells with dot gain: of even and odd ones, one kind grows into the other.
HWY_INLINE void AddGrownPoint(const LaneModel& m, V x, V y, V part, const PowerTerms* terms, Picture& p) {
  struct Axis {
    GrownCells share, slope, bend, gain;
  } along, down;
  const V gain = m.of(ModelLanes::kGain), one = Splat(1);
  const auto fill = [&](V at, V scale, ModelLanes::Parameter moves, const PowerTerms& of, Axis& axis) HWY_ATTR {
    const V even[kEdges] = {m.value[moves], one, m.value[moves + 1]},
            odd[kEdges] = {m.value[moves + 2], hn::Neg(one), m.value[moves + 3]};
    V even_shift[kEdges], odd_shift[kEdges], even_gain[kEdges], odd_gain[kEdges];
    for (int k = 0; k < kEdges; ++k) even_shift[k] = hn::Mul(even[k], gain), odd_shift[k] = hn::Mul(odd[k], gain);
    EdgesAlong sooner, later;
    BlurAlong(at, even_shift, scale, of, sooner);
    BlurAlong(at, odd_shift, scale, of, later);
    Grow(sooner.share, later.share, true, axis.share);
    Grow(sooner.slope, later.slope, false, axis.slope);
    Grow(sooner.bend, later.bend, false, axis.bend);
    for (int k = 0; k < kEdges; ++k)
      even_gain[k] = hn::Mul(even[k], sooner.slope[k]), odd_gain[k] = hn::Mul(odd[k], later.slope[k]);
    Grow(even_gain, odd_gain, false, axis.gain);
  };
  fill(x, m.of(ModelLanes::kScaleX), ModelLanes::kEvenX0, terms[0], along);
  fill(y, m.of(ModelLanes::kScaleY), ModelLanes::kEvenY0, terms[1], down);
  GrownRows rows, by_x, bend_x, by_gain;
  RowsOf(m, along.share, rows);
  RowsOf(m, along.slope, by_x);
  RowsOf(m, along.bend, bend_x);
  RowsOf(m, along.gain, by_gain);
  const V light_by_x = LightOf(by_x, down.share), light_by_y = LightOf(rows, down.slope);
  p.light = hn::Add(p.light, LightOf(rows, down.share));
  AddSlopes(m, part, light_by_x, light_by_y, LightOf(bend_x, down.slope), LightOf(by_x, down.bend), p);
  AddBends(m, LightOf(bend_x, down.share), LightOf(rows, down.bend), p);
  p.by_gain = hn::Add(p.by_gain, hn::Add(LightOf(by_gain, down.share), LightOf(rows, down.gain)));
  p.by_xy = hn::Add(p.by_xy, LightOf(by_x, down.slope));
  p.twist_by_both = hn::Add(p.twist_by_both, LightOf(bend_x, down.bend));
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const bool even = (i + j) % 2 == 0;
      const V half = m.of(even ? ModelLanes::kHalfEven : ModelLanes::kHalfOdd);
      const auto cell = [&](const GrownCells& rows_of, const GrownCells& cols_of) HWY_ATTR {
        const V own = even ? hn::Mul(rows_of.grown[j], cols_of.grown[i]) : hn::Mul(rows_of.given[j], cols_of.given[i]);
        return hn::NegMulAdd(hn::Mul(rows_of.overlap[j], cols_of.overlap[i]), half, own);
      };
      p.share[j][i] = hn::Add(p.share[j][i], cell(down.share, along.share));
      if (m.skewed) p.share[j][i] = hn::MulAdd(m.of(ModelLanes::kSkew), cell(down.slope, along.slope), p.share[j][i]);
    }
}

HWY_INLINE void Scale(V by, Picture& p) {
  for (V* value : {&p.light, &p.by_x, &p.by_y, &p.by_blur, &p.by_gain, &p.by_xy, &p.by_xx, &p.by_yy, &p.way_x, &p.way_y,
                   &p.twist_by_both})
    *value = hn::Mul(*value, by);
  for (auto& row : p.share)
    for (V& cell : row) cell = hn::Mul(cell, by);
}

/// Edges that are not square to each other, or are blurred by motion along both, blur together: what that does to the
/// light, to the first order of the blur's covariance. Where they are far from square, to the second, and what it does
/// to the derivative by the blur, to the first: places and cells' shares have it from each point of the way.
HWY_INLINE void Twist(const LaneModel& m, Picture& p) {
  p.light = hn::MulAdd(m.of(ModelLanes::kCovariance), p.by_xy, p.light);
  if (!m.skewed) return;
  const V skew = m.of(ModelLanes::kSkew), scale_x = m.of(ModelLanes::kScaleX), scale_y = m.of(ModelLanes::kScaleY);
  const V per_both = hn::Mul(hn::Mul(scale_x, scale_x), hn::Mul(scale_y, scale_y));
  const V by_skew = hn::Mul(hn::Mul(per_both, skew), p.twist_by_both);
  p.light = hn::MulAdd(hn::Mul(skew, Splat(0.5f)), by_skew, p.light);
  p.by_blur = hn::MulAdd(m.of(ModelLanes::kSkewByBlur), hn::Add(p.by_xy, by_skew), p.by_blur);
}

void LookAt(const ModelInput& input, const LaneModel& m, V x, V y, const PowerTerms* terms, Picture& p) {
  p.Clear();
  const float taps = static_cast<float>(input.taps);
  for (int tap = 0; tap < input.taps; ++tap) {
    const V part = Splat((static_cast<float>(tap) + 0.5f) / taps - 0.5f);
    const V at_x = hn::MulAdd(part, m.of(ModelLanes::kWayX), x), at_y = hn::MulAdd(part, m.of(ModelLanes::kWayY), y);
    input.terms.dot_gain ? AddGrownPoint(m, at_x, at_y, part, terms, p) : AddPoint(m, at_x, at_y, part, terms, p);
  }
  if (input.taps > 1) Scale(Splat(1 / taps), p);
  Twist(m, p);
}

/// The light of a shadow that falls on it. @param x, y on the board. Writes the derivatives by the shadow.
HWY_INLINE void CastShadow(const ModelInput& input, const LaneModel& m, V x, V y, const PowerTerms& gaussian,
                           Picture& p, V* by_shadow) {
  const D d;
  const auto& s = input.shadow;
  const V across = hn::Sub(hn::MulAdd(Splat(s.normal_x), x, hn::Mul(Splat(s.normal_y), y)), Splat(s.offset));
  const V a = hn::Mul(across, Splat(s.per_width));
  const Normal normal = NormalAt(d, hn::Mul(a, Splat(kUnit)), gaussian);
  const V takes = Splat(s.takes), density = hn::Mul(normal.density, Splat(kDensity * s.per_width));
  const V lit = hn::NegMulAdd(takes, normal.integral, Splat(1)), fall = hn::Mul(takes, density);
  // How the light of the board changes along what the blur mixes across the edge.
  const V qx = m.of(ModelLanes::kShadowX), qy = m.of(ModelLanes::kShadowY);
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
  by_shadow[0] = hn::Neg(taken);
  const V by_offset = hn::Mul(fall, hn::NegMulAdd(hn::Mul(a, Splat(s.per_width)), mixed, even));
  const V along = hn::NegMulAdd(Splat(s.normal_y), x, hn::Mul(Splat(s.normal_x), y));
  by_shadow[1] = hn::Neg(hn::Mul(by_offset, along));
  by_shadow[2] = by_offset;
  by_shadow[3] = hn::Mul(by_offset, across);
  // The edge stays where it is on the board, which moves under the pixels.
  p.by_x = hn::NegMulAdd(Splat(s.normal_x), by_offset, hn::Mul(lit, p.by_x));
  p.by_y = hn::NegMulAdd(Splat(s.normal_y), by_offset, hn::Mul(lit, p.by_y));
  for (V* value : {&p.by_blur, &p.by_gain, &p.way_x, &p.way_y, &p.by_xx, &p.by_xy, &p.by_yy})
    *value = hn::Mul(*value, lit);
  for (auto& row : p.share)
    for (V& cell : row) cell = hn::Mul(cell, lit);
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#endif  // CHEQUER_DETECT_MODEL_LIGHT
