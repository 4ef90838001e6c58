// Of PhotometricFit: boards that shadows cross, or that mirror a lamp.
#include <algorithm>
#include <cmath>

#include "detect/fit/fit.h"

namespace chequer {
namespace {

/// A corner that fits so much worse than a quarter of them may be crossed by the edge of a shadow.
constexpr double kUnevenMisfit = 3;
/// The same where corners lie so much farther off the plane than noise puts them: where cells are small against the
/// blur, or dot gain is strong, a shadow moves corners before it spoils their fit. In other boards, paper that is not
/// flat does so too.
constexpr double kUnevenShifts = 1.5;
/// Light cells of one ink then differ by more than prints do; a lens that is not known well moves corners too, but
/// leaves the cells alike.
constexpr double kUnevenCells = 0.02;
/// In smaller cells that blur into each other, levels of quadrants tell nothing.
constexpr double kLeastBlurredCellPx = 6;
/// Steps until quadrants' levels tell of a shadow's edge: where the board lies was known before.
constexpr int kStepsOfQuadrants = 4;
/// Of the lights on a board where no cell is crossed by used corners' account: the most over the least of a shadow.
/// Light that falls off by less is told better by the cells' levels.
constexpr float kShadow = 1.6f;

/// Whether the lights on a board tell of one.
bool InShadow(const FittedBoard& board) {
  CellLight all;
  for (const CellLight& lit : board.lit) {
    if (lit.crossed()) return true;
    if (lit.most == 0) continue;
    all = {all.most == 0 ? lit.least : std::min(all.least, lit.least), std::max(all.most, lit.most)};
  }
  return all.most > kShadow * all.least;
}

/// The standard deviation of light cells of one ink from their mean, over it.
double Unevenness(const FittedBoard& board, const BoardFit::Start& start) {
  std::array<double, 2> sum{}, square{}, count{};
  for (int cell = 0; cell < start.size.rows * start.size.cols; ++cell) {
    const std::size_t i = static_cast<std::size_t>(cell), ink = start.saturated[i] != 0 ? 1 : 0;
    if (IsDark(cell / start.size.cols, cell % start.size.cols) || start.covered[i]) continue;
    const double light = static_cast<double>(board.levels[i].sum());
    sum[ink] += light;
    square[ink] += light * light;
    ++count[ink];
  }
  double variance = 0, cells = 0;
  for (std::size_t ink = 0; ink < count.size(); ++ink) {
    if (!(count[ink] > 1 && sum[ink] > 0)) continue;
    const double mean = sum[ink] / count[ink];
    variance += square[ink] / (mean * mean) - count[ink];
    cells += count[ink] - 1;
  }
  return cells > 0 ? std::sqrt(std::max(variance, 0.0) / cells) : 0;
}

}  // namespace

bool PhotometricFit::MayBeUnevenlyLit(const Task& task) const {
  if (!fit_.motion_px().isZero()) return false;
  if (AnyOf(choice_.left_out)) return true;
  if (fit_.looks_farther()) {
    if (fit_.cell_px() < kLeastBlurredCellPx) return false;
    if (AnyOf(fit_.Occluded())) return true;
    if (fit_.unexplained_shifts() > kUnevenShifts && Unevenness(fit_.result(), task.start) > kUnevenCells) return true;
  }
  if (fit_.misfit_spread() <= kUnevenMisfit) return false;
  // Inks out of register spoil the fit of corners, too, but leave the cells alike.
  if (!task.start.register_cells.isZero() && Unevenness(fit_.result(), task.start) <= kUnevenCells) return false;
  std::array<double, kMaxCorners> misfits;
  std::ptrdiff_t count = 0;
  for (int corner = 0; corner < fit_.corners(); ++corner)
    if (fit_.used(corner)) misfits[static_cast<std::size_t>(count++)] = fit_.misfit(corner);
  if (count == 0) return false;
  const auto past = misfits.begin() + count, quarter = misfits.begin() + count / 4;
  const double most = *std::max_element(misfits.begin(), past);
  std::nth_element(misfits.begin(), quarter, past);
  return most > kUnevenMisfit * *quarter;
}

bool PhotometricFit::FitChosen(const Task& task, Hypothesis hypothesis, std::initializer_list<const Kept*> others) {
  const auto among = [&](bool (*better)(const Explained&, const Explained&, Hypothesis)) {
    return std::all_of(others.begin(), others.end(), [&](const Kept* other) {
      return better(fit_.result().explained, other->run.result.explained, hypothesis);
    });
  };
  if (!Refit(task) || !among(MayBeBetter) || !fit_.FitClosely(task.reader, task.lens, task.start)) return false;
  if (choice_.terms.dot_gain == 0 && !fit_.result().flat()) fit_.FitDotGain(task.reader, task.lens, task.start);
  return among(Better);
}

bool PhotometricFit::FitHighlight(const Task& task) {
  const std::optional<HighlightTerm> highlight = fit_.FindHighlight(task.start.saturated);
  if (!highlight) return false;
  Keep(evenly_lit_);
  choice_ = {};
  static_cast<HighlightTerm&>(choice_.terms) = *highlight;
  choice_.terms.dot_gain = fit_.dot_gain();
  choice_.roughly = true;
  choice_.from = &evenly_lit_.run;
  if (FitChosen(task, Hypothesis::kHighlight, {&evenly_lit_})) return true;
  Restore(evenly_lit_);
  return false;
}

bool PhotometricFit::FitUnevenlyLit(const Task& task) {
  Keep(evenly_lit_);
  choice_ = {};
  choice_.own_levels = choice_.roughly = true;
  choice_.most_steps_near = kStepsOfQuadrants;
  choice_.terms.dot_gain = fit_.dot_gain();
  if (fit_.looks_farther()) choice_.from = &evenly_lit_.run;
  // Levels of quadrants take up a part of the blur: by what that leaves, edges would not be the image's.
  BoardFit::Start start = task.start;
  if (fit_.looks_farther() && !start.image) start.image = &evenly_lit_.run.result.image;
  const Task by_quadrants{task.reader, task.lens, start};
  if (Refit(by_quadrants)) {
    // A shadow's edge mostly shows among the corners as they are; else without those that are occluded.
    if (FitShadow(by_quadrants)) return true;
    LeaveOutOccluded(by_quadrants);
    if (AnyOf(choice_.left_out) && FitShadow(by_quadrants)) return true;
    if (InShadow(fit_.result()) && BetterThan(evenly_lit_, Hypothesis::kQuadrants) &&
        fit_.FitClosely(task.reader, task.lens, start))
      return true;
  }
  Restore(evenly_lit_);
  return false;
}

bool PhotometricFit::FitShadow(const Task& task) {
  const std::optional<ShadowEdge> shadow = FindShadowEdge(fit_.LitParts(task.start.saturated));
  if (!shadow) return false;
  Keep(own_levels_);
  choice_ = {};
  // The lens makes no edge sharper than its blur, which parts of cells do not show.
  ShadowEdge::Parameters values = shadow->values();
  values[ShadowEdge::kLogWidth] =
      std::max(values[ShadowEdge::kLogWidth], std::log(fit_.result().image.blur_px / fit_.cell_px()));
  choice_.terms.ShadowTerm::Start(values);
  choice_.terms.dot_gain = fit_.dot_gain();
  choice_.roughly = true;
  choice_.from = &own_levels_.run;
  // What the board says of noise and blur by levels of its own holds in the shadow too.
  BoardFit::Start start = task.start;
  if (!start.image) start.image = &own_levels_.run.result.image;
  const Task shaded{task.reader, task.lens, start};
  if (FitChosen(shaded, Hypothesis::kShadow, {&own_levels_, &evenly_lit_})) return true;
  Restore(own_levels_);
  return false;
}

}  // namespace chequer
