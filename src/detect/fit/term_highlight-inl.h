// A highlight: a lamp that glossy paper or laminate mirrors adds light to the board's, a Gaussian spot, to cells of all
// inks alike and coloured as white paper is. The lens's blur widens it to another Gaussian.
#ifndef CHEQUER_DETECT_TERM_HIGHLIGHT
#define CHEQUER_DETECT_TERM_HIGHLIGHT

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "chequer/hidden.h"
#include "detect/fit/term.h"

namespace chequer {

struct HighlightTerm {
  enum Parameter { kAmount, kX, kY, kLogWidth, kColumns };
  enum Lane { kWhite, kLanes };  ///< light of white paper
  struct Input {
    float amount = 0, x = 0, y = 0, per_width_square = 1;
  };
  using Parameters = Eigen::Vector4d;
  /// The least kLogWidth; a kAmount that moves a board of 20 px cells by about a standard deviation (reckoned: .11
  /// moved one by six).
  static constexpr double kSpeck = -1.2, kUnseen = 0.02;

  /// At its middle, over the light of white paper; where that is, on the board; logarithm of its standard deviation,
  /// cells.
  Parameters spot = Parameters::Zero(), spot_start = Parameters::Zero();
  PhaseValues white{};

  bool on() const { return spot[kAmount] > 0; }
  /// Whether it counts on a board. One beyond its outer cells' middles counts by what it adds there: less is what lies
  /// beside the board, or a motion that is not quite known.
  bool IsSeenOn(MarkerSize size) const {
    const Eigen::Vector2d outer = Eigen::Vector2d(size.cols - 1, size.rows - 1) / 2,
                          there = spot.segment<2>(kX).cwiseMax(-outer).cwiseMin(outer);
    return At(there) > kUnseen && spot[kLogWidth] > kSpeck;
  }

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
    spot += step.As<Parameters>().cwiseMax(-most).cwiseMin(most);
    // Wider ones are light that falls off; it stays on.
    constexpr double kLeast = 1e-4, kMostLogWidth = 1.6;
    spot[kAmount] = std::max(spot[kAmount], kLeast);
    spot[kLogWidth] = std::clamp(spot[kLogWidth], kSpeck, kMostLogWidth);
    return step.Make<Parameters>(spot - before, still);
  }

  /// What Find() looks at, cell by cell, row by row.
  struct Cells {
    MarkerSize size;
    std::span<const PhaseValues> levels;
    std::span<const std::uint8_t> saturated;
    std::span<const Hidden> hidden;  ///< only cells that show tell
    std::size_t phase = 0;           ///< that tells
  };
  /// The spot of least squares over the dark cells' levels, each ink with a level of its own beside a slope: what
  /// scales light hardly shows in them. Nothing where cells of one ink are alike (1 µs), where the spot leaves much of
  /// what they differ by, or where light cells show something else. 0.1 ms.
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

/// Of a board's cells in plain view.
struct Ranges {
  Range dark, light;

  explicit Ranges(const HighlightTerm::Cells& cells) {
    ForCells(cells.size, [&](std::size_t cell, int row, int col) {
      if (cells.hidden[cell] != Hidden::kNot) return;
      (IsDark(row, col) ? dark : light).Add(cells.saturated[cell] != 0, cells.levels[cell][cells.phase]);
    });
  }
  double white() const { return double{light.least[0]}; }
};

/// The light of white paper that a spot adds least to: as much of the phase that tells as the darkest white cell has,
/// and the colour of most of them, as overexposed yellow cells may pass for white ones. @pre there is a white cell.
inline PhaseValues WhiteLight(const HighlightTerm::Cells& cells, double darkest) {
  PhaseValues white{};
  for (std::size_t phase = 0; phase < white.size(); ++phase) {
    std::array<float, kMaxCells> levels;
    auto end = levels.begin();
    ForCells(cells.size, [&](std::size_t cell, int row, int col) {
      if (!IsDark(row, col) && cells.saturated[cell] == 0 && cells.hidden[cell] == Hidden::kNot)
        *end++ = cells.levels[cell][phase];
    });
    const auto median = levels.begin() + (end - levels.begin()) / 2;
    std::nth_element(levels.begin(), median, end);
    white[phase] = *median;
  }
  const float scale = static_cast<float>(darkest) / white[cells.phase];
  for (float& of_phase : white) of_phase *= scale;
  return white;
}

/// Levels of a board's light cells, or of its dark ones, less what they differ by beside a spot: each ink has a level
/// of its own, and light that falls off, and was taken out by light cells, leaves a slope.
class Levels {
 public:
  /// By cell.
  using PerCell = Eigen::Array<float, Eigen::Dynamic, 1, 0, kMaxCells, 1>;

  void Add(int row, int col, bool coloured, float of) {
    // Levels of one ink are alike to a share and to noise (a guess). Lighter ones are saturated.
    constexpr float kAlike = 0.03f, kNoise = 0.004f, kMostLevel = 0.95f;
    if (of > kMostLevel) return;
    row_[count_] = static_cast<float>(row), col_[count_] = static_cast<float>(col);
    weight_[count_] = 1 / (kAlike * of + kNoise);
    level_[count_] = of;
    coloured_[count_] = coloured;
    ++count_;
  }
  /// Takes off what they differ by beside a spot (Gram and Schmidt). Once, after all are added.
  void Prepare() {
    for (PerCell* values : {&row_, &col_, &weight_, &level_, &coloured_}) values->conservativeResize(count_);
    level_ *= weight_;
    beside_ = {weight_ * coloured_, weight_ * (1 - coloured_), weight_ * col_, weight_ * row_};
    for (std::size_t k = 0; k < kBeside; ++k) {
      const float before = beside_[k].square().sum();
      for (std::size_t earlier = 0; earlier < k; ++earlier)
        beside_[k] -= (beside_[k] * beside_[earlier]).sum() * beside_[earlier];
      const float left = beside_[k].square().sum();
      // Of one ink, or in one line, some are nothing beside the others.
      constexpr float kLeastLeft = 1e-5f;
      beside_[k] *= left > kLeastLeft * before ? 1 / std::sqrt(left) : 0;
    }
    for (const PerCell& of : beside_) level_ -= (level_ * of).sum() * of;
    squares_ = double{level_.square().sum()};
  }
  /// Of what is left of them, over what cells of one ink are expected to differ by.
  double squares() const { return squares_; }
  /// How many cells are left to tell them, beside so many unknowns more.
  double FreeBeside(int unknowns) const {
    return static_cast<double>(std::max<Eigen::Index>(count_ - kBeside - unknowns, 0));
  }

  /// How a spot's light falls off along an axis. @param at where its middle is, half cells. @param width cells.
  PerCell AlongX(int at, float width) const { return Fall(col_, at, width); }
  PerCell AlongY(int at, float width) const { return Fall(row_, at, width); }

  /// By linear least squares: a spot's amount, and by what the squares fall.
  struct Amount {
    double of = 0, gain = 0;
  };
  /// @param x, y how its light falls off.
  Amount AmountOf(const PerCell& x, const PerCell& y) const {
    const PerCell spot = weight_ * x * y;
    float gg = spot.square().sum();
    for (const PerCell& of : beside_) {
      const float along = (spot * of).sum();
      gg -= along * along;
    }
    const double gy = double{(spot * level_).sum()}, square = double{std::max(gg, 1e-9f)};
    return {gy / square, gy * gy / square};
  }

 private:
  static constexpr int kBeside = 4;

  static PerCell Fall(const PerCell& middles, int at, float width) {
    return ((middles + 0.5f - 0.5f * static_cast<float>(at)).square() * (-0.5f / (width * width))).exp();
  }

  Eigen::Index count_ = 0;
  PerCell row_ = PerCell::Zero(kMaxCells), col_ = PerCell::Zero(kMaxCells), coloured_ = PerCell::Zero(kMaxCells);
  PerCell weight_ = PerCell::Zero(kMaxCells), level_ = PerCell::Zero(kMaxCells);  ///< levels are weighted
  std::array<PerCell, kBeside> beside_{};
  double squares_ = 0;
};

}  // namespace highlight

inline std::optional<HighlightTerm> HighlightTerm::Find(const Cells& cells) {
  // Of the light of white paper, what dark cells of one ink differ by at least (without a spot, by less than .02:
  // measured; less only costs trials that fail). The share that a spot leaves of that at most. What light cells tell of
  // it, over what dark ones do: a shading that was taken out of the light leaves nothing of it there, but shadows show
  // ten times as much there, and things that lie on a board show the reverse.
  constexpr double kLeastSpread = 0.03, kLeaves = 0.42, kLeastInLight = -0.3, kMostInLight = 2.5, kMostAmount = 6,
                   kOtherwiseInLight = 0.2;  // of print and shading
  constexpr int kBeyond = 3;                 // the middle lies as many half cells beyond the rim at most
  const int rows = cells.size.rows, cols = cells.size.cols, places = 2 * (rows + kBeyond) + 1;
  // Most boards have none, which the range of their levels tells.
  const highlight::Ranges ranges(cells);
  const double white = ranges.white(), spread = ranges.dark.Spread();
  if (ranges.light.most[0] == 0 || !(white > 0) || spread < kLeastSpread * white) return std::nullopt;
  if (ranges.light.Spread() > kMostInLight * spread + kOtherwiseInLight * white) return std::nullopt;
  highlight::Levels dark, light;
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (cells.hidden[cell] != Hidden::kNot) return;
    (IsDark(row, col) ? dark : light).Add(row, col, cells.saturated[cell] != 0, cells.levels[cell][cells.phase]);
  });
  dark.Prepare(), light.Prepare();
  if (dark.FreeBeside(kColumns) == 0) return std::nullopt;
  double best = dark.squares() * (1 - kLeaves * dark.FreeBeside(kColumns) / dark.FreeBeside(0));
  const auto light_agrees = [&](int x, int y, float width, double in_dark) {
    if (light.FreeBeside(1) == 0) return true;  // of overexposed boards, no light cells may be left that tell it
    const double in_light = light.AmountOf(light.AlongX(x, width), light.AlongY(y, width)).of;
    return in_light >= kLeastInLight * in_dark && in_light <= kMostInLight * in_dark;
  };
  HighlightTerm found;
  found.white = highlight::WhiteLight(cells, white);
  std::array<highlight::Levels::PerCell, 2 * (kMaxCells / 3 + kBeyond) + 1> down;  // by place, of dark cells
  for (const float width : {0.5f, 0.8f, 1.2f, 1.9f}) {
    for (int i = 0; i < places; ++i) down[static_cast<std::size_t>(i)] = dark.AlongY(i - kBeyond, width);
    for (int x = -kBeyond; x <= 2 * cols + kBeyond; ++x) {
      const highlight::Levels::PerCell along = dark.AlongX(x, width);
      for (int i = 0; i < places; ++i) {
        const highlight::Levels::Amount in_dark = dark.AmountOf(along, down[static_cast<std::size_t>(i)]);
        if (!(in_dark.gain > best) || !(in_dark.of > 0)) continue;
        const int y = i - kBeyond;
        if (!light_agrees(x, y, width, in_dark.of)) continue;
        best = in_dark.gain;
        found.spot = Parameters(in_dark.of / white, 0.5 * (x - cols), 0.5 * (y - rows), std::log(double{width}));
      }
    }
  }
  if (!found.on() || found.spot[kAmount] > kMostAmount) return std::nullopt;
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
