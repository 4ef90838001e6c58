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
  bool skewed;               ///< some lane has a kSkew that is not 0
  V variance_x, variance_y;  ///< of a tap's blur, cells²

  HWY_INLINE V of(ModelLanes::Parameter which) const { return value[which]; }
  /// Of a term's own.
  template <class Term>
  HWY_INLINE V of(int which) const {
    return value[ModelLanes::Of<Term>(which)];
  }
};

void Load(const ModelInput& input, const ModelLanes& model, int first, LaneModel& m) {
  const D d;
  for (int i = 0; i < ModelLanes::kLevel00; ++i) m.value[i] = hn::LoadU(d, model.parameter_data(i) + first);
  m.skewed = !hn::AllTrue(d, hn::Eq(m.of(ModelLanes::kSkew), hn::Zero(d)));
  const V scale_x = m.of(ModelLanes::kScaleX), scale_y = m.of(ModelLanes::kScaleY), one = Splat(1);
  m.variance_x = hn::Div(one, hn::Mul(scale_x, scale_x));
  m.variance_y = hn::Div(one, hn::Mul(scale_y, scale_y));
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
    light = by_x = by_y = by_gain = by_xy = by_xx = by_yy = way_x = way_y = zero;
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

/// How edges are blurred across an axis.
struct EdgeProfile {
  explicit EdgeProfile(const EdgeTerms& edge) : terms(PowerTermsOf(edge)) {
    far = NormalAt(D(), Splat(-kFarthestNormal), terms);
  }

  PowerTerms terms;
  Normal far;  ///< so far below an edge and farther
};

/// How far a point lies from each edge along an axis. @param at from the middle one, cells.
HWY_INLINE void LookFromEdges(V at, V* from) {
  for (int k = 0; k < kEdges; ++k) from[k] = hn::Sub(at, Splat(static_cast<float>(k - 1)));
}

/// @param from distance from each edge, cells.
HWY_INLINE void BlurAlong(const V* from, V scale, const EdgeProfile& profile, EdgesAlong& edges) {
  const D d;
  const V unit = hn::Mul(scale, Splat(kUnit)), density = hn::Mul(scale, Splat(kDensity));
  for (int k = 0; k < kEdges; ++k) {
    const V away = hn::Mul(from[k], unit);
    // Where edges lie many blurs from each other, one or two of them are near. What stands in for the others is what
    // would be found: no lane depends on those beside it.
    Normal normal = profile.far;
    if (hn::AllTrue(d, hn::Ge(hn::Abs(away), Splat(kFarthestNormal))))
      normal.integral = hn::IfNegativeThenElse(away, normal.integral, hn::Sub(Splat(1), normal.integral));
    else
      normal = NormalAt(d, away, profile.terms);
    edges.share[k] = normal.integral;
    edges.slope[k] = hn::Mul(normal.density, density);
    edges.bend[k] = hn::Neg(hn::Mul(from[k], edges.slope[k]));
  }
}

/// Σ_k row[k + 1] edge[k].
HWY_INLINE V AtEdges(const V* row, const V* edge) {
  return hn::MulAdd(row[1], edge[0], hn::MulAdd(row[2], edge[1], hn::Mul(row[3], edge[2])));
}

/// The second derivatives along x and y of a point's light, in units of the blur's variances: see FromBends().
HWY_INLINE void AddBends(V bend_x, V bend_y, Picture& p) {
  p.by_xx = hn::Add(p.by_xx, bend_x);
  p.by_yy = hn::Add(p.by_yy, bend_y);
}

/// What these make of the light: how it changes with the blur, and with the place.
HWY_INLINE void FromBends(const LaneModel& m, Picture& p) {
  const V scale_x = m.of(ModelLanes::kScaleX), scale_y = m.of(ModelLanes::kScaleY);
  p.by_blur = hn::MulAdd(p.by_xx, m.of(ModelLanes::kBlurX), hn::Mul(p.by_yy, m.of(ModelLanes::kBlurY)));
  p.by_xx = hn::Mul(p.by_xx, hn::Mul(scale_x, scale_x));
  p.by_yy = hn::Mul(p.by_yy, hn::Mul(scale_y, scale_y));
}

/// How the light's derivatives by the place at a point of the way change along both axes, in units of the blur's
/// variances; the last one that by both.
struct Twists {
  V by_x, by_y, by_both;
};

/// The light's derivatives by the place at a point of the way, given those of a blur without covariance.
/// @param twists () → Twists.
template <class TwistsOf>
HWY_INLINE void AddSlopes(const LaneModel& m, V part, V by_x, V by_y, const TwistsOf& twists, Picture& p) {
  if (m.skewed) {
    const V skew = m.of(ModelLanes::kSkew), scale_x = m.of(ModelLanes::kScaleX), scale_y = m.of(ModelLanes::kScaleY);
    const Twists twist = twists();
    by_x = hn::MulAdd(hn::Mul(skew, hn::Mul(scale_x, scale_x)), twist.by_x, by_x);
    by_y = hn::MulAdd(hn::Mul(skew, hn::Mul(scale_y, scale_y)), twist.by_y, by_y);
    p.twist_by_both = hn::Add(p.twist_by_both, twist.by_both);
  }
  p.by_x = hn::Add(p.by_x, by_x);
  p.by_y = hn::Add(p.by_y, by_y);
  p.way_x = hn::MulAdd(part, by_x, p.way_x);
  p.way_y = hn::MulAdd(part, by_y, p.way_y);
}

/// A point of the way, cells printed as they should be. In place of the light and of the cells' shares, products of the
/// edges' shares are summed up, also with those of an edge before the first one, on whose far side all lies:
/// FromEdges() makes light and cells of them, once a pixel. @param part of the way, −½ … ½.
HWY_INLINE void AddPoint(const LaneModel& m, V x, V y, V part, const EdgeProfile* profiles, Picture& p) {
  EdgesAlong along, down;
  V from_x[kEdges], from_y[kEdges];
  LookFromEdges(x, from_x);
  LookFromEdges(y, from_y);
  BlurAlong(from_x, m.of(ModelLanes::kScaleX), profiles[0], along);
  BlurAlong(from_y, m.of(ModelLanes::kScaleY), profiles[1], down);
  V row[kSide], by_x[kSide], bend_x[kSide];
  for (int j = 0; j < kSide; ++j) {
    if (j > 0) row[j] = hn::Add(m.step[j][0], AtEdges(m.step[j], along.share));
    by_x[j] = AtEdges(m.step[j], along.slope);
    bend_x[j] = AtEdges(m.step[j], along.bend);
  }
  const V light_by_x = hn::Add(by_x[0], AtEdges(by_x, down.share)), light_by_y = AtEdges(row, down.slope);
  const auto twists = [&]() HWY_ATTR {
    return Twists{AtEdges(bend_x, down.slope), AtEdges(by_x, down.bend), AtEdges(bend_x, down.bend)};
  };
  AddSlopes(m, part, light_by_x, light_by_y, twists, p);
  AddBends(hn::Add(bend_x[0], AtEdges(bend_x, down.share)), AtEdges(row, down.bend), p);
  p.by_xy = hn::Add(p.by_xy, AtEdges(by_x, down.slope));
  p.share[0][0] = hn::Add(p.share[0][0], Splat(1));
  for (int i = 0; i < kEdges; ++i) p.share[0][i + 1] = hn::Add(p.share[0][i + 1], along.share[i]);
  for (int j = 0; j < kEdges; ++j) {
    p.share[j + 1][0] = hn::Add(p.share[j + 1][0], down.share[j]);
    for (int i = 0; i < kEdges; ++i)
      p.share[j + 1][i + 1] = hn::MulAdd(down.share[j], along.share[i], p.share[j + 1][i + 1]);
  }
  if (!m.skewed) return;
  for (int j = 0; j < kEdges; ++j) {
    const V skew = hn::Mul(m.of(ModelLanes::kSkew), down.slope[j]);
    for (int i = 0; i < kEdges; ++i) p.share[j + 1][i + 1] = hn::MulAdd(skew, along.slope[i], p.share[j + 1][i + 1]);
  }
}

/// The light and the cells' shares, of what AddPoint() has summed up.
HWY_INLINE void FromEdges(const LaneModel& m, Picture& p) {
  // Other than the shares, the light has not got what the blur's covariance makes of it: see Twist().
  p.light = hn::NegMulAdd(m.of(ModelLanes::kSkew), p.by_xy, p.light);
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) p.light = hn::MulAdd(m.step[j][i], p.share[j][i], p.light);
  // A cell is what lies beyond its first edges, less what lies beyond its last ones.
  for (auto& row : p.share)
    for (int i = 0; i < kEdges; ++i) row[i] = hn::Sub(row[i], row[i + 1]);
  for (int j = 0; j < kEdges; ++j)
    for (int i = 0; i < kSide; ++i) p.share[j][i] = hn::Sub(p.share[j][i], p.share[j + 1][i]);
}

HWY_INLINE void Scale(V by, Picture& p) {
  for (V* value :
       {&p.light, &p.by_x, &p.by_y, &p.by_gain, &p.by_xy, &p.by_xx, &p.by_yy, &p.way_x, &p.way_y, &p.twist_by_both})
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

/// How the light of a point of the board changes as the board's coordinates are stretched around it: by ∂δx/∂x, ∂δx/∂y,
/// ∂δy/∂x and ∂δy/∂y of a move δ of them. What the image has, a blur or a way, is as much longer or turned as far on
/// the board. (Measured: steps that took it for fixed on the board left 5 to 10 % of the way to the minimum where a
/// board moved by a cell, and 2 to 4 % with this.)
struct ByStretch {
  V xx, xy, yx, yy;
};

/// What a term does to the light of pixels. It has some of
///   AddPoints(input, m, x, y, p, add_point)  a pixel's light is the mean over several points: add_point(x, y, part),
///   AddPoint(m, x, y, part, profiles, p)     a point's, in place of AddPoint() below,
///   Bend(input, m, x, y, gaussian, p, by)    what it makes of the light and of its derivatives by the place, and those
///                                            by its unknowns, at a point of the board; if it scales the light, it
///                                            returns by how much, and all other derivatives are scaled,
///   Derive(m, x, y, p, by)                   the derivatives by its unknowns at a point of the board, where Bend()
///                                            does not write them,
///   AddStretch(m, p, by)                     what a stretch of the board does to what it has in the image.
/// Terms that bend the light follow each other.
template <class Term>
struct OnLanes;

/// A pixel's derivatives by the unknowns of all terms, those of a term from Terms::BeforeTerm() on.
struct ByTerms {
  V by[Terms::kColumns];

  template <class Term>
  HWY_INLINE V* of() {
    return by + Terms::BeforeTerm<Term>().columns;
  }
};

/// visit<Term>() of the terms that are on. Here, as a function for all processors would not be inlined.
template <class... Term, class Visit>
HWY_INLINE void ForEachTerm(TermList<Term...>, const ModelTerms& terms, const Visit& visit) {
  ((terms.on<Term>() ? visit.template operator()<Term>() : void()), ...);
}

// Here, in this namespace: what they need for themselves was included before.
#define CHEQUER_TERMS_ON_LANES
#include "detect/fit/terms.h"
#undef CHEQUER_TERMS_ON_LANES

/// Whether no term adds points in its own way.
HWY_INLINE bool AddsByEdges(const ModelTerms& on) {
  bool adds = true;
  ForEachTerm(Terms(), on, [&]<class Term>() HWY_ATTR {
    if constexpr (requires { &OnLanes<Term>::AddPoint; }) adds = false;
  });
  return adds;
}

/// @tparam kByEdges AddsByEdges(): what is asked once a pixel is not asked at each of its points.
template <bool kByEdges>
void LookAt(const ModelInput& input, const LaneModel& m, V x, V y, const EdgeProfile* profiles, Picture& p) {
  p.Clear();
  const auto look_at = [&](V at_x, V at_y, V part) HWY_ATTR {
    if constexpr (kByEdges) return AddPoint(m, at_x, at_y, part, profiles, p);
    ForEachTerm(Terms(), input.terms, [&]<class Term>() HWY_ATTR {
      if constexpr (requires { OnLanes<Term>::AddPoint(m, at_x, at_y, part, profiles, p); })
        OnLanes<Term>::AddPoint(m, at_x, at_y, part, profiles, p);
    });
  };
  bool added = false;
  ForEachTerm(Terms(), input.terms, [&]<class Term>() HWY_ATTR {
    if constexpr (requires { OnLanes<Term>::AddPoints(input, m, x, y, p, look_at); })
      OnLanes<Term>::AddPoints(input, m, x, y, p, look_at), added = true;
  });
  if (!added) look_at(x, y, hn::Zero(D()));
  FromBends(m, p);
  if constexpr (kByEdges) FromEdges(m, p);
  Twist(m, p);
}

HWY_INLINE void LookAt(const ModelInput& input, const LaneModel& m, V x, V y, const EdgeProfile* profiles, Picture& p) {
  AddsByEdges(input.terms) ? LookAt<true>(input, m, x, y, profiles, p) : LookAt<false>(input, m, x, y, profiles, p);
}

/// What a term that scales the light makes of derivatives that it does not know: by what a Picture has, and by unknowns
/// of the terms before it.
template <class Scaling>
HWY_INLINE void ScaleOthers(V light, const ModelTerms& terms, Picture& p, ByTerms& by) {
  for (V* value : {&p.by_blur, &p.by_gain, &p.way_x, &p.way_y, &p.by_xx, &p.by_xy, &p.by_yy})
    *value = hn::Mul(*value, light);
  for (auto& row : p.share)
    for (V& cell : row) cell = hn::Mul(cell, light);
  ForEachTerm(Terms(), terms, [&]<class Term>() HWY_ATTR {
    constexpr bool kBefore = Terms::BeforeTerm<Term>().terms < Terms::BeforeTerm<Scaling>().terms;
    if constexpr (kBefore && requires { &OnLanes<Term>::Bend; })
      for (int i = 0; i < Term::kColumns; ++i) by.of<Term>()[i] = hn::Mul(by.of<Term>()[i], light);
  });
}

/// What the terms make of the light at a point of the board.
HWY_INLINE void Bend(const ModelInput& input, const LaneModel& m, V x, V y, const PowerTerms& gaussian, Picture& p,
                     ByTerms& by) {
  ForEachTerm(Terms(), input.terms, [&]<class Term>() HWY_ATTR {
    if constexpr (requires { OnLanes<Term>::Bend(input, m, x, y, gaussian, p, by.of<Term>()); }) {
      V* own = by.of<Term>();
      if constexpr (std::is_void_v<decltype(OnLanes<Term>::Bend(input, m, x, y, gaussian, p, own))>)
        OnLanes<Term>::Bend(input, m, x, y, gaussian, p, own);
      else
        ScaleOthers<Term>(OnLanes<Term>::Bend(input, m, x, y, gaussian, p, own), input.terms, p, by);
    }
  });
  ForEachTerm(Terms(), input.terms, [&]<class Term>() HWY_ATTR {
    if constexpr (requires { OnLanes<Term>::Derive(m, x, y, p, by.of<Term>()); })
      OnLanes<Term>::Derive(m, x, y, p, by.of<Term>());
  });
}

HWY_INLINE ByStretch StretchOf(const ModelInput& input, const LaneModel& m, const Picture& p) {
  // A blur's variances and covariance make light spread by half of its second derivatives, and by that by both.
  const V covariance = m.of(ModelLanes::kCovariance);
  ByStretch by{hn::MulAdd(p.by_xx, m.variance_x, hn::Mul(p.by_xy, covariance)),
               hn::MulAdd(p.by_xx, covariance, hn::Mul(p.by_xy, m.variance_y)),
               hn::MulAdd(p.by_yy, covariance, hn::Mul(p.by_xy, m.variance_x)),
               hn::MulAdd(p.by_yy, m.variance_y, hn::Mul(p.by_xy, covariance))};
  ForEachTerm(Terms(), input.terms, [&]<class Term>() HWY_ATTR {
    if constexpr (requires { OnLanes<Term>::AddStretch(m, p, by); }) OnLanes<Term>::AddStretch(m, p, by);
  });
  return by;
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#endif  // CHEQUER_DETECT_MODEL_LIGHT
