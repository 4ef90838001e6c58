// Of PhotometricFit: boards that shadows cross.
#include <algorithm>

#include "detect/fit.h"

namespace chequer {
namespace {

/// A corner that fits so much worse than a quarter of them may be crossed by the edge of a shadow.
constexpr double kUnevenMisfit = 3;
/// Where lights on a board differ and no single edge explains it, levels for each corner's quadrants tell so much more
/// of it, if no corners seemed hidden without.
constexpr double kMoreByOwn = 1.5;
/// One edge of a shadow explains no more than quadrants' levels, but leaves the cells' to tell the inks, and hides no
/// corners: it has to tell about as much of the board.
constexpr double kAsMuchByShadow = 0.8;
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

bool AnyOf(const CornerFlags& corners) { return std::find(corners.begin(), corners.end(), true) != corners.end(); }

/// How much a fit tells of the board, over what one of 1 : 1 says of a corner.
double Told(const FittedBoard& board) { return board.signal_to_noise * board.signal_to_noise * board.corners_used; }

}  // namespace

bool PhotometricFit::MayBeUnevenlyLit() const {
  if (!choice_.smear_px.isZero()) return false;
  if (AnyOf(choice_.left_out)) return true;
  if (fit_.misfit_spread() <= kUnevenMisfit) return false;
  std::array<double, kMaxCorners> misfits;
  std::ptrdiff_t count = 0;
  for (int corner = 0; corner < fit_.corners(); ++corner)
    if (fit_.used(corner)) misfits[static_cast<std::size_t>(count++)] = fit_.Misfit(corner);
  if (count == 0) return false;
  const auto past = misfits.begin() + count, quarter = misfits.begin() + count / 4;
  const double most = *std::max_element(misfits.begin(), past);
  std::nth_element(misfits.begin(), quarter, past);
  return most > kUnevenMisfit * *quarter;
}

bool PhotometricFit::FitUnevenlyLit(const Task& task) {
  evenly_lit_ = fit_.result();
  const BoardFit::Choice evenly = choice_;
  choice_ = {};
  choice_.own_levels = true;
  if (FitAnew(task) && !fit_.takes_out_light()) {
    LeaveOutHidden(task);
    if (FitShadow(task)) return true;
    const double more = AnyOf(evenly.left_out) ? 1 : kMoreByOwn;
    if (InShadow(fit_.result()) && Told(fit_.result()) > more * Told(evenly_lit_)) return true;
  }
  choice_ = evenly;
  fit_.GoBackTo(evenly_lit_);
  return false;
}

bool PhotometricFit::FitShadow(const Task& task) {
  const std::optional<ShadowEdge> shadow = FindShadowEdge(fit_.LitParts(task.start.saturated));
  if (!shadow) return false;
  own_levels_ = fit_.result();
  const BoardFit::Choice own = choice_;
  choice_ = {};
  choice_.shadow = shadow;
  // What the board says of noise and blur by levels of its own holds in the shadow too.
  BoardFit::Start start = task.start;
  start.geometry = own_levels_.geometry;
  if (!start.image) start.image = &own_levels_.image;
  const Task shaded{task.reader, task.lens, start};
  const double least = kAsMuchByShadow * std::max(Told(own_levels_), Told(evenly_lit_));
  if (FitAnew(shaded) && !fit_.takes_out_light()) {
    choice_.shadow = fit_.shadow();
    LeaveOutHidden(shaded);
    if (Told(fit_.result()) > least) return true;
  }
  choice_ = own;
  fit_.GoBackTo(own_levels_);
  return false;
}

}  // namespace chequer
