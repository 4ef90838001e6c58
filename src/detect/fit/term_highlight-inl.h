// A highlight: a lamp that glossy paper or laminate mirrors adds light to the board's, a Gaussian spot, to cells of all
// inks alike and coloured as white paper is. The lens's blur widens it to another Gaussian.
#ifndef CHEQUER_DETECT_TERM_HIGHLIGHT
#define CHEQUER_DETECT_TERM_HIGHLIGHT

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "detect/fit/term.h"

namespace chequer {

struct HighlightTerm {
  enum Parameter { kAmount, kX, kY, kLogWidth, kColumns };
  enum Lane { kWhite, kLanes };  ///< light of white paper
  struct Input {
    float amount = 0, x = 0, y = 0, per_width_square = 1;
  };
  using Parameters = Eigen::Vector4d;

  /// At its middle, over the light of white paper; where that is, on the board; logarithm of its standard deviation,
  /// cells.
  Parameters spot = Parameters::Zero(), spot_start = Parameters::Zero();
  PhaseValues white{};

  bool on() const { return spot[kAmount] > 0; }

  double At(const Eigen::Vector2d& board) const {
    return spot[kAmount] * std::exp(-(board - spot.segment<2>(kX)).squaredNorm() * std::exp(-2 * spot[kLogWidth]) / 2);
  }

  void LightAt(const Eigen::Vector2d& board, LightThere& light) const {
    const float here = static_cast<float>(At(board));
    for (std::size_t phase = 0; phase < white.size(); ++phase) light.more[phase] += here * white[phase];
  }

  void SetInput(double /*blur_px*/, bool /*roughly*/, Input& input) const {
    const auto value = [](double of) { return static_cast<float>(of); };
    input = {value(spot[kAmount]), value(spot[kX]), value(spot[kY]), value(std::exp(-2 * spot[kLogWidth]))};
  }

  template <class Set>
  void SetLanes(const Input& /*input*/, const TermCorner& /*corner*/, const Set& set) const {
    set(kWhite, white);
  }

  template <class Vector>
  void AddPrior(Vector information, Vector pull) const {
    // What the cells tell of it before the pixels are looked at: standard deviations, a guess.
    const Parameters known_to(0.02 + 0.5 * spot_start[kAmount], 0.4, 0.4, 0.5);
    SetPrior<Parameters>(known_to, spot_start - spot, information, pull);
  }

  double Move(const TermStep& step) {
    // Longer steps lead elsewhere; then what no longer counts, a thousandth of the light or less.
    const Parameters most(0.05 + 0.3 * spot[kAmount], 0.3, 0.3, 0.3), still(0.003, 0.01, 0.01, 0.01), before = spot;
    spot += Eigen::Map<const Parameters>(step.of).cwiseMax(-most).cwiseMin(most);
    // Narrower ones are specks, wider ones light that falls off; it stays on.
    constexpr double kLeast = 1e-4, kLeastLogWidth = -1.2, kMostLogWidth = 1.6;
    spot[kAmount] = std::max(spot[kAmount], kLeast);
    spot[kLogWidth] = std::clamp(spot[kLogWidth], kLeastLogWidth, kMostLogWidth);
    return step.MostThatCounts<Parameters>(spot - before, still);
  }

  /// What Find() looks at, cell by cell, row by row.
  struct Cells {
    MarkerSize size;
    std::span<const PhaseValues> levels;
    std::span<const std::uint8_t> saturated;
    std::size_t phase = 0;  ///< that tells
    double blur = 0;        ///< that levels have of their neighbours' light, cells
  };
  /// The spot of least squares over the dark cells' levels, each ink with a level of its own: what scales light hardly
  /// shows in them. Nothing where cells of one ink are alike (1 µs), where the spot leaves much of what they differ by,
  /// or where light cells show something else. 0.1 ms.
  static std::optional<HighlightTerm> Find(const Cells& cells);
};

namespace highlight {

/// What levels lie between, of cells without and with a colour.
struct Range {
  std::array<float, 2> least{1e9f, 1e9f}, most{};

  void Add(bool coloured, float level) {
    least[coloured] = std::min(least[coloured], level);
    most[coloured] = std::max(most[coloured], level);
  }
  double Spread() const { return double{std::max(most[0] - least[0], most[1] - least[1])}; }
};

/// The cells of a board that are light, or dark: those that have blue or yellow for themselves.
struct Cells {
  std::array<double, kMaxCells> level{}, weight{};
  std::array<int, kMaxCells> row{}, col{};
  std::array<bool, kMaxCells> colour{};
  std::size_t count = 0;

  void Add(int at_row, int at_col, bool coloured, float of) {
    // Levels of one ink are alike to a share and to noise (a guess). Lighter ones are saturated.
    constexpr double kAlike = 0.03, kNoise = 0.004, kMostLevel = 0.95;
    const double value = double{of}, deviation = kAlike * value + kNoise;
    level[count] = value, row[count] = at_row, col[count] = at_col, colour[count] = coloured;
    weight[count++] = value > kMostLevel ? 0 : 1 / (deviation * deviation);
  }
};

/// By linear least squares, each ink with a level of its own: the spot's amount, what squares fall by, and from what.
struct Amount {
  double of = 0, gain = 0, squares = 0;
};

/// @param fall of the spot's light along an axis, by distance, half cells. @param x, y of its middle, half cells.
inline Amount AmountIn(const Cells& cells, const double* fall, int x, int y) {
  struct {
    double n = 0, g = 0, y = 0, gg = 0, gy = 0, yy = 0;
  } sums[2];
  for (std::size_t i = 0; i < cells.count; ++i) {
    const double n = cells.weight[i], level = cells.level[i],
                 g = fall[std::abs(2 * cells.col[i] + 1 - x)] * fall[std::abs(2 * cells.row[i] + 1 - y)];
    auto& s = sums[cells.colour[i]];
    s.n += n, s.g += n * g, s.y += n * level, s.gg += n * g * g, s.gy += n * g * level, s.yy += n * level * level;
  }
  double gg = 1e-9, gy = 0, yy = 0;
  for (const auto& s : sums)
    if (s.n > 0) gg += s.gg - s.g * s.g / s.n, gy += s.gy - s.g * s.y / s.n, yy += s.yy - s.y * s.y / s.n;
  return {gy / gg, gy * gy / gg, yy};
}

}  // namespace highlight

inline std::optional<HighlightTerm> HighlightTerm::Find(const Cells& cells) {
  // Of the light of white paper, what dark cells of one ink differ by at least (a motion too short to be told from blur
  // makes them differ by as much as the blur has of a cell: measured, .07 at .11); the share that a spot leaves of that
  // at most. What light cells tell of it, over what dark ones do: a shading that was taken out of the light leaves
  // nothing of it there, but shadows show ten times as much there, and things that lie on a board show the reverse.
  constexpr double kLeastSpread = 0.04, kLeaves = 0.3, kLeastInLight = -0.3, kMostInLight = 2.5, kMostAmount = 6,
                   kOtherwiseInLight = 0.2;  // of print and shading
  constexpr int kBeyond = 3;                 // the middle lies as many half cells beyond the rim at most
  const int rows = cells.size.rows, cols = cells.size.cols;
  // Most boards have none, which the range of their levels tells.
  highlight::Range of_dark, of_light;
  std::size_t whitest = 0;  // of white cells, the one that it adds least to
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    const float level = cells.levels[cell][cells.phase], least = of_light.least[0];
    (IsDark(row, col) ? of_dark : of_light).Add(cells.saturated[cell] != 0, level);
    if (of_light.least[0] < least) whitest = cell;
  });
  const double white = double{of_light.least[0]};
  if (of_light.most[0] == 0 || !(white > 0) || of_dark.Spread() < std::max(kLeastSpread, cells.blur) * white)
    return std::nullopt;
  if (of_light.Spread() > kMostInLight * of_dark.Spread() + kOtherwiseInLight * white) return std::nullopt;
  highlight::Cells dark, light;
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    (IsDark(row, col) ? dark : light).Add(row, col, cells.saturated[cell] != 0, cells.levels[cell][cells.phase]);
  });
  double best = 0;
  HighlightTerm found;
  found.white = cells.levels[whitest];
  std::array<double, 2 * kMaxCells + 2 * kBeyond> fall;
  for (const double width : {0.5, 0.8, 1.2, 1.9}) {
    for (int i = 0; i <= 2 * std::max(rows, cols) + kBeyond; ++i)
      fall[static_cast<std::size_t>(i)] = std::exp(-i * i / (8 * width * width));
    for (int x = -kBeyond; x <= 2 * cols + kBeyond; ++x)
      for (int y = -kBeyond; y <= 2 * rows + kBeyond; ++y) {
        const highlight::Amount in_dark = highlight::AmountIn(dark, fall.data(), x, y);
        if (!(in_dark.gain > best) || !(in_dark.gain > (1 - kLeaves) * in_dark.squares) || !(in_dark.of > 0)) continue;
        const double in_light = highlight::AmountIn(light, fall.data(), x, y).of;
        if (in_light < kLeastInLight * in_dark.of || in_light > kMostInLight * in_dark.of) continue;
        best = in_dark.gain;
        found.spot = Parameters(in_dark.of / white, 0.5 * (x - cols), 0.5 * (y - rows), std::log(width));
      }
  }
  if (best == 0 || found.spot[kAmount] > kMostAmount) return std::nullopt;
  found.spot_start = found.spot;
  return found;
}

}  // namespace chequer

#endif  // CHEQUER_DETECT_TERM_HIGHLIGHT

#ifdef CHEQUER_TERMS_ON_LANES
template <>
struct OnLanes<HighlightTerm> {
  static HWY_INLINE void Bend(const HighlightTerm::Input& s, const LaneModel& m, V x, V y,
                              const PowerTerms& /*gaussian*/, Picture& p, V* by) {
    const D d;
    const V white = m.of<HighlightTerm>(HighlightTerm::kWhite), per_square = Splat(s.per_width_square);
    const V dx = hn::Sub(x, Splat(s.x)), dy = hn::Sub(y, Splat(s.y));
    const V square = hn::Mul(per_square, hn::MulAdd(dx, dx, hn::Mul(dy, dy)));
    constexpr float kHalfInPowersOf2 = 0.72134752f, kMostPower = 60;
    const V there = hn::Mul(white, TwoToMinus(d, hn::Min(hn::Mul(square, Splat(kHalfInPowersOf2)), Splat(kMostPower))));
    const V light = hn::Mul(there, Splat(s.amount)), slope = hn::Mul(light, per_square);
    p.light = hn::Add(p.light, light);
    by[HighlightTerm::kAmount] = there;
    by[HighlightTerm::kX] = hn::Mul(slope, dx);
    by[HighlightTerm::kY] = hn::Mul(slope, dy);
    by[HighlightTerm::kLogWidth] = hn::Mul(light, square);
    // The spot stays where it is on the board, which moves under the pixels.
    p.by_x = hn::Sub(p.by_x, by[HighlightTerm::kX]);
    p.by_y = hn::Sub(p.by_y, by[HighlightTerm::kY]);
  }
};
#endif  // CHEQUER_TERMS_ON_LANES
