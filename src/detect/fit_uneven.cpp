// Of PhotometricFit: boards that shadows cross.
#include <algorithm>

#include "detect/fit.h"

namespace chequer {
namespace {

/// A corner that fits so much worse than the median one may be crossed by the edge of a shadow.
constexpr double kUnevenMisfit = 3;
/// Levels of their own for each corner's quadrants leave a board that a shadow crosses as clear as it was, where most
/// of the edge was found hidden, or make it clearer.
constexpr double kAsClearByOwn = 0.95;
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

}  // namespace

bool PhotometricFit::MayBeUnevenlyLit() const {
  if (!choice_.smear_px.isZero() || fit_.misfit_spread() <= kUnevenMisfit) return false;
  const CornerFlags& left_out = choice_.left_out;
  if (std::find(left_out.begin(), left_out.end(), true) != left_out.end()) return true;
  std::array<double, kMaxCorners> misfits;
  std::size_t count = 0;
  for (int corner = 0; corner < fit_.corners(); ++corner)
    if (fit_.used(corner)) misfits[count++] = fit_.Misfit(corner);
  const auto past = misfits.begin() + static_cast<std::ptrdiff_t>(count),
             middle = misfits.begin() + static_cast<std::ptrdiff_t>(count / 2);
  if (count == 0) return false;
  const double most = *std::max_element(misfits.begin(), past);
  std::nth_element(misfits.begin(), middle, past);
  return most > kUnevenMisfit * *middle;
}

void PhotometricFit::FitUnevenlyLit(const Task& task) {
  evenly_lit_ = fit_.result();
  const BoardFit::Choice evenly = choice_;
  choice_ = {.own_levels = true};
  if (FitAnew(task) && !fit_.takes_out_light()) {
    LeaveOutHidden(task);
    const double clearer = fit_.result().signal_to_noise / evenly_lit_.signal_to_noise;
    if (clearer > kAsClearByOwn && InShadow(fit_.result())) return;
  }
  choice_ = evenly;
  fit_.GoBackTo(evenly_lit_);
}

}  // namespace chequer
