// Dot gain: dark cells grow on each side. Their edges move, and where two of them meet, each has half.
#ifndef CHEQUER_DETECT_TERM_DOT_GAIN
#define CHEQUER_DETECT_TERM_DOT_GAIN

#include "detect/fit/term.h"

namespace chequer {

struct DotGainTerm {
  static constexpr int kColumns = 1;  ///< cells
  enum Lane {
    kGain,  ///< positive where the cells of even row + column are dark, else negative
    /// By how much of it edges move, along x and y, the first and the last of the three (the middle one by all of it):
    /// those of the even cells, then of the odd ones. At the board's rim only dark cells move.
    kEvenX0,
    kEvenX2,
    kOddX0,
    kOddX2,
    kEvenY0,
    kEvenY2,
    kOddY0,
    kOddY2,
    kHalfEven,  ///< ½ where those are dark, else 0
    kHalfOdd,   ///< ½ − that
    kLanes
  };
  struct Input {};
  /// Ink spreads over no more of a cell; longer steps lead elsewhere. Cells.
  static constexpr double kMost = 0.3, kMostStep = 0.05;

  double dot_gain = 0;  ///< cells
  bool ink = false;     ///< it is fitted where there is none yet

  bool on() const { return ink || dot_gain != 0; }

  template <class Set>
  void SetLanes(const Input& /*input*/, const TermCorner& corner, const Set& set) const {
    const bool even_dark = corner.even_dark();
    set(kGain, even_dark ? dot_gain : -dot_gain);
    // An edge of the rim moves out where its cell is dark, and stays where it is light: half of the gain either way
    // about a line half of it farther out.
    const double out = even_dark ? 0.5 : -0.5;
    const auto set_rim = [&](int first, bool at_start, bool at_end) {
      set(first, at_start ? 0.5 + out : 1);
      set(first + 1, at_end ? 0.5 - out : 1);
      set(first + 2, at_start ? -0.5 + out : -1);
      set(first + 3, at_end ? -0.5 - out : -1);
    };
    set_rim(kEvenX0, corner.col == 0, corner.col == corner.size.cols - 2);
    set_rim(kEvenY0, corner.row == 0, corner.row == corner.size.rows - 2);
    set(kHalfEven, even_dark ? 0.5 : 0);
    set(kHalfOdd, even_dark ? 0 : 0.5);
  }

  double Move(const TermStep& step) {
    constexpr double kStill = 0.0003;  // cells
    const double before = dot_gain;
    dot_gain = std::clamp(dot_gain + std::clamp(step.of[0], -kMostStep, kMostStep), -kMost, kMost);
    return step.Make(0, dot_gain - before, kStill);
  }

  /// Starts by the first step to it, which levels and blur had taken up a part of.
  void Start(double step) {
    constexpr double kFirstStep = 1.75;  // the gain over it: measured
    ink = true;
    dot_gain = std::clamp(kFirstStep * step, -2 * kMostStep, 2 * kMostStep);
  }
};

}  // namespace chequer

#endif  // CHEQUER_DETECT_TERM_DOT_GAIN

#ifdef CHEQUER_TERMS_ON_LANES

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
  const V half_even = m.of<DotGainTerm>(DotGainTerm::kHalfEven), half_odd = m.of<DotGainTerm>(DotGainTerm::kHalfOdd);
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

template <>
struct OnLanes<DotGainTerm> {
  /// A point of the way: of even and odd cells, one kind grows into the other.
  static HWY_INLINE void AddPoint(const LaneModel& m, V x, V y, V part, const EdgeProfile* profiles, Picture& p) {
    struct Axis {
      GrownCells share, slope, bend, gain;
    } along, down;
    const V gain = m.of<DotGainTerm>(DotGainTerm::kGain), one = Splat(1);
    const auto fill = [&](V at, V scale, DotGainTerm::Lane moves, const EdgeProfile& of, Axis& axis) HWY_ATTR {
      const V even[kEdges] = {m.of<DotGainTerm>(moves), one, m.of<DotGainTerm>(moves + 1)},
              odd[kEdges] = {m.of<DotGainTerm>(moves + 2), hn::Neg(one), m.of<DotGainTerm>(moves + 3)};
      V from[kEdges], from_even[kEdges], from_odd[kEdges], even_gain[kEdges], odd_gain[kEdges];
      LookFromEdges(at, from);
      for (int k = 0; k < kEdges; ++k) {
        from_even[k] = hn::MulAdd(even[k], gain, from[k]);
        from_odd[k] = hn::MulAdd(odd[k], gain, from[k]);
      }
      EdgesAlong sooner, later;
      BlurAlong(from_even, scale, of, sooner);
      BlurAlong(from_odd, scale, of, later);
      Grow(sooner.share, later.share, true, axis.share);
      Grow(sooner.slope, later.slope, false, axis.slope);
      Grow(sooner.bend, later.bend, false, axis.bend);
      for (int k = 0; k < kEdges; ++k)
        even_gain[k] = hn::Mul(even[k], sooner.slope[k]), odd_gain[k] = hn::Mul(odd[k], later.slope[k]);
      Grow(even_gain, odd_gain, false, axis.gain);
    };
    fill(x, m.of(ModelLanes::kScaleX), DotGainTerm::kEvenX0, profiles[0], along);
    fill(y, m.of(ModelLanes::kScaleY), DotGainTerm::kEvenY0, profiles[1], down);
    GrownRows rows, by_x, bend_x, by_gain;
    RowsOf(m, along.share, rows);
    RowsOf(m, along.slope, by_x);
    RowsOf(m, along.bend, bend_x);
    RowsOf(m, along.gain, by_gain);
    const V light_by_x = LightOf(by_x, down.share), light_by_y = LightOf(rows, down.slope);
    p.light = hn::Add(p.light, LightOf(rows, down.share));
    const auto twists = [&]() HWY_ATTR {
      return Twists{LightOf(bend_x, down.slope), LightOf(by_x, down.bend), LightOf(bend_x, down.bend)};
    };
    AddSlopes(m, part, light_by_x, light_by_y, twists, p);
    AddBends(LightOf(bend_x, down.share), LightOf(rows, down.bend), p);
    p.by_gain = hn::Add(p.by_gain, hn::Add(LightOf(by_gain, down.share), LightOf(rows, down.gain)));
    p.by_xy = hn::Add(p.by_xy, LightOf(by_x, down.slope));
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const bool even = (i + j) % 2 == 0;
        const V half = m.of<DotGainTerm>(even ? DotGainTerm::kHalfEven : DotGainTerm::kHalfOdd);
        const auto cell = [&](const GrownCells& rows_of, const GrownCells& cols_of) HWY_ATTR {
          const V own =
              even ? hn::Mul(rows_of.grown[j], cols_of.grown[i]) : hn::Mul(rows_of.given[j], cols_of.given[i]);
          return hn::NegMulAdd(hn::Mul(rows_of.overlap[j], cols_of.overlap[i]), half, own);
        };
        p.share[j][i] = hn::Add(p.share[j][i], cell(down.share, along.share));
        if (m.skewed) p.share[j][i] = hn::MulAdd(m.of(ModelLanes::kSkew), cell(down.slope, along.slope), p.share[j][i]);
      }
  }

  static HWY_INLINE void Derive(const LaneModel& m, V /*x*/, V /*y*/, const Picture& p, V* by) {
    // Where the even cells are light, they give way as the others grow.
    const V sign =
        hn::Mul(Splat(2), hn::Sub(m.of<DotGainTerm>(DotGainTerm::kHalfEven), m.of<DotGainTerm>(DotGainTerm::kHalfOdd)));
    by[0] = hn::Mul(sign, p.by_gain);
  }
};

#endif  // CHEQUER_TERMS_ON_LANES
