#include "detect/identity/cell_inks.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/median.h"
#include "detect/common/light.h"

namespace chequer {
namespace {

/// Least spread of ink about its means, as a share of the distance of the means: prints and illumination vary (a
/// guess).
constexpr double kLeastSpread = 0.07;
/// The fewest cells for an estimate of the spread about the nearer mean (a guess).
constexpr int kFewestOfSpread = 4;

/// Weights of green that are added to blue to separate blue cells from black ones, both as shares of white. −1 is
/// linear −b*: a highlight leaves it as it is, and black cells are not as noisy as under the cube root of CIE L*a*b*.
/// Where chroma is coarser or noisier than luma, sums have less noise than differences: of 1,080 boards with JPEG's 6
/// px cells in low light, 98.6 % are read with all three and 94.5 % with −1 alone.
constexpr std::array<float, 3> kGreenWithBlue{-1, 0, 1};
/// Below this spread, as a share of the distance of the means, no other measure of ink is tried (a guess).
constexpr double kClearSpread = 0.12;

/// A dark cell is under a highlight if its red light exceeds that of the dark border cells by this share of the
/// distance from black to blue. Less is noise (a guess).
constexpr double kClearVeil = 0.25;

/// Darker boards have no white to measure colours by (a guess).
constexpr float kLeastWhite = 1e-5f;

float BlueOf(const Eigen::Vector3f& light, const Eigen::Vector3f& white, float green) {
  return light[2] / white[2] + green * light[1] / white[1];
}

/// Tells yellow from white: how much less blue there is than red and green, as shares of white's. A veil of white
/// light, such as the mirror image of a lamp, leaves it as it is.
float YellowOf(const Eigen::Vector3f& light, const Eigen::Vector3f& white) {
  return RedAndGreen::Of(light[0] / white[0], light[1] / white[1]) - light[2] / white[2];
}

}  // namespace

double WeakerLead(double lead, double other) {
  if (lead * other <= 0) return 0;
  return std::abs(lead) < std::abs(other) ? lead : other;
}

bool CellInks::MeasureWhite(const ShownCells& cells) {
  Eigen::Vector3f& white = board_->white;
  white.setZero();
  int whites = 0;
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (!IsBorder(cells.size, row, col) || !cells.visibility.Shows(cell) || IsDark(row, col) || cells.border[cell])
      return;
    white += cells.lights.light[cell];
    ++whites;
  });
  if (whites == 0) return false;
  white /= static_cast<float>(whites);
  return white.minCoeff() > kLeastWhite;
}

bool CellInks::Measure(const ShownCells& cells) {
  if (!MeasureWhite(cells)) return false;
  const std::size_t count = cells.lights.light.size();
  board_->colours.resize(count);
  board_->ink.resize(count);
  board_->veil.assign(count, 0);
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    board_->colours[cell] = chequer::ColourOf(cells.lights.light[cell], board_->white, IsDark(row, col), space_);
    board_->ink[cell] = board_->colours[cell].saturation;
  });
  if (space_ == ColorSpace::kLab) {
    board_->classes[1] = MeasureBlue(cells);
    // Elsewhere, what tells inks is the same under a veil.
    const bool may_count = board_->green != kGreenWithBlue[0] || std::ranges::count(cells.lights.overexposed, 1) > 0;
    const bool veiled = may_count && board_->classes[1].usable && FindVeils(cells);
    board_->classes[0] = MeasureYellow(cells, veiled);
    TakeVeilsOff(cells);
  } else {
    board_->classes = {ClassOf(cells, false), ClassOf(cells, true)};
    board_->bare = board_->ink;
  }
  return board_->classes[0].usable || board_->classes[1].usable;
}

InkClass CellInks::MeasureYellow(const ShownCells& cells, bool veiled) {
  const InkClass by_saturation = ClassOf(cells, false);
  if (by_saturation.usable && by_saturation.spread() < kClearSpread && !veiled) return by_saturation;
  const auto fill = [&](const auto& ink_of) {
    ForCells(cells.size, [&](std::size_t cell, int row, int col) {
      if (!IsDark(row, col)) board_->ink[cell] = ink_of(cell);
    });
  };
  fill([&](std::size_t cell) { return YellowOf(cells.lights.light[cell], board_->white); });
  const InkClass by_difference = ClassOf(cells, false);
  if (by_difference.usable && (veiled || !by_saturation.usable || by_difference.spread() < by_saturation.spread()))
    return by_difference;
  fill([&](std::size_t cell) { return board_->colours[cell].saturation; });
  return by_saturation;
}

InkClass CellInks::MeasureBlue(const ShownCells& cells) {
  float& green = board_->green;
  const auto mix = [&](float with_green) {
    ForCells(cells.size, [&](std::size_t cell, int row, int col) {
      if (IsDark(row, col)) board_->ink[cell] = BlueOf(cells.lights.light[cell], board_->white, with_green);
    });
    return ClassOf(cells, true);
  };
  float last = green = kGreenWithBlue[0];
  InkClass best = mix(green);
  if (best.usable && best.spread() < kClearSpread) return best;
  for (const float with_green : std::span(kGreenWithBlue).subspan(1)) {
    const InkClass other = mix(last = with_green);
    if (!other.usable || (best.usable && other.spread() >= best.spread())) continue;
    best = other;
    green = with_green;
  }
  return last == green ? best : mix(green);
}

bool CellInks::FindVeils(const ShownCells& cells) {
  const InkClass& dark = Of(true);
  // Black and blue have as little red light as each other: what a cell has more is white light over it.
  const auto red_of = [&](std::size_t cell) { return cells.lights.light[cell][0] / board_->white[0]; };
  std::vector<float>& values = board_->values;
  values.clear();
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (IsDark(row, col) && IsBorder(cells.size, row, col) && cells.visibility.Shows(cell))
      values.push_back(red_of(cell));
  });
  const float usual = MedianInPlace(values), least = static_cast<float>(kClearVeil * (dark.inked - dark.plain));
  bool any = false;
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (!IsDark(row, col) || red_of(cell) - usual <= least) return;
    board_->veil[cell] = red_of(cell) - usual;
    any = true;
  });
  return any;
}

void CellInks::TakeVeilsOff(const ShownCells& cells) {
  board_->bare = board_->ink;
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (IsDark(row, col))
      board_->bare[cell] -= (1 + board_->green) * board_->veil[cell];
    else if (cells.lights.overexposed[cell])
      // What tells yellow is the same under a veil, but not where red and green end at full scale: there it adds blue.
      board_->bare[cell] += VeilBeside(cells.size, row, col);
  });
}

float CellInks::VeilBeside(MarkerSize size, int row, int col) const {
  float most = 0;
  constexpr std::array<std::array<int, 2>, 4> kBeside{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
  for (const auto& [down, right] : kBeside) {
    const int at_row = row + down, at_col = col + right;
    if (at_row < 0 || at_col < 0 || at_row >= size.rows || at_col >= size.cols) continue;
    most = std::max(most, board_->veil[static_cast<std::size_t>(at_row * size.cols + at_col)]);
  }
  return most;
}

InkClass CellInks::ClassOf(const ShownCells& cells, bool dark) const {
  std::array<GaussianSum, 2> groups;
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (IsDark(row, col) != dark || !IsBorder(cells.size, row, col)) return;
    if (cells.visibility.Shows(cell) && cells.lights.half_lit[cell] == 1)
      groups[cells.border[cell]].Add(board_->ink[cell]);
  });
  const Gaussian plain = groups[0].Get(), inked = groups[1].Get();
  InkClass c;
  c.usable = plain.count >= 2 && inked.count >= 2 && inked.mean > plain.mean;
  if (!c.usable) return c;
  c.plain = plain.mean;
  c.inked = inked.mean;
  const int freedom = plain.count + inked.count - 2;
  const double pooled =
      (plain.deviation * plain.deviation * (plain.count - 1) + inked.deviation * inked.deviation * (inked.count - 1)) /
      freedom;
  // Few cells tell their spread badly: a prior of two cells at the least spread.
  const double distance = c.inked - c.plain, least = kLeastSpread * distance;
  c.deviation = std::max(std::sqrt((pooled * freedom + 2 * least * least) / (freedom + 2)), least);
  // The kernel's cells may lie farther from the nearer mean: JPEG leaves other errors in each pattern of inks, and the
  // border's is regular. They decide a cell for less than it deserves, never for more.
  c.deviation = std::max(c.deviation, KernelDeviation(cells, dark, c));
  return c;
}

double CellInks::KernelDeviation(const ShownCells& cells, bool dark, const InkClass& by_border) const {
  GaussianSum off;
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (IsDark(row, col) != dark || IsBorder(cells.size, row, col) || !cells.visibility.Shows(cell)) return;
    const double from_plain = board_->ink[cell] - by_border.plain, from_inked = board_->ink[cell] - by_border.inked;
    off.Add(std::abs(from_plain) < std::abs(from_inked) ? from_plain : from_inked);
  });
  const Gaussian kernel = off.Get();
  if (kernel.count < kFewestOfSpread) return 0;
  return std::sqrt(kernel.mean * kernel.mean + kernel.deviation * kernel.deviation * (kernel.count - 1) / kernel.count);
}

double CellInks::LeadOf(std::size_t cell, bool dark, float half_lit) const {
  const InkClass& c = Of(dark);
  const double distance = c.inked - c.plain;
  const auto lead_of = [&](double ink) { return (ink - c.plain) / distance - 0.5; };
  const double ink = board_->ink[cell];
  double lead = lead_of(ink);
  for (const double other : {lead_of(half_lit * ink), lead_of(board_->bare[cell])}) lead = WeakerLead(lead, other);
  return lead;
}

}  // namespace chequer
