// Of BoardFit: corners that something hides.
#include <algorithm>

#include "detect/fit/board_fit.h"

namespace chequer {
namespace {

/// A corner whose pixels disagree so much more than the median corner's is occluded.
constexpr double kOccludedRatio = 8;
/// One beside a corner that is not used is pulled if it disagrees so much more than the median corner (measured: of
/// hands across a column of cells, corners beside it had 3 to 6 times as much, others up to 1.8).
constexpr double kPulledRatio = 2;
/// What hides a corner may end anywhere between it and the next one, which is still used if its own pixels show little
/// of that. Pixels farther towards the hidden one than that, cells, count nothing (measured: of 1,433 blurred boards
/// with covers, 15, 16, 18 and 25 have gross errors with .2, .25, .3 and .35, 55 with pixels up to half a cell; of
/// 3,024 sharp ones, 14 to 17 with any of these), and those within so many pixels before it less and less.
constexpr double kReachToHidden = 0.25, kFadePx = 0.8;
/// Where cells blur into each other, levels fit a corner's few pixels more or less by chance: as many pixels more of it
/// are asked for.
constexpr double kFewPixels = 24;
/// Corners with less of the median corner's contrast are occluded too.
constexpr double kOccludedContrast = 0.2;

}  // namespace

void BoardFit::BeginVisibility(const Visibility& known) {
  Visibility& visibility = run_->visibility;
  visibility = known;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!known.ShowsCorner(corner)) visibility.HideCellsBeside(corner);
    if (!pixels_.inside(corner))
      visibility.Set(corner, Hidden::kOutside);
    else if (known.ShowsCorner(corner) && known.LiesBesideHidden(corner))
      visibility.Set(corner, Hidden::kBeside);
  }
}

double BoardFit::MisfitOf(int corner) const {
  const int pixels = pixels_.pixels(corner);
  const float* const squares = pixels_.lanes().sum_data(ProductSum(kResidual, kResidual)) + pixels_.Lane(corner);
  return pixels > 0 ? double{Eigen::Map<const Eigen::Array4f>(squares).sum()} / pixels : 1e9;
}

bool BoardFit::FindOccludedCorners(bool may_return) {
  std::array<double, kMaxCorners> misfit, contrast, sorted;
  double least_misfit = 1e9, most_misfit = 0, least_contrast = 1e9, most_contrast = -1e9;
  int count = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!usable(corner)) continue;
    const std::size_t i = static_cast<std::size_t>(corner);
    misfit[i] = MisfitOf(corner);
    contrast[i] = Contrast(corner);
    least_misfit = std::min(least_misfit, misfit[i]);
    most_misfit = std::max(most_misfit, misfit[i]);
    least_contrast = std::min(least_contrast, contrast[i]);
    most_contrast = std::max(most_contrast, contrast[i]);
    ++count;
  }
  run_->told.misfit_spread = most_misfit / std::max(least_misfit, 1e-9);
  // Corners that are all alike are all near the median one.
  const bool alike =
      least_contrast >= kOccludedContrast * most_contrast && most_misfit <= kOccludedRatio * least_misfit;
  const int pixels_of_corner = pixels_.middle().pixels;
  const double ratio = kOccludedRatio * (run_->terms.look_farther ? 1 + kFewPixels / std::max(pixels_of_corner, 1) : 1);
  const auto median = [&](const std::array<double, kMaxCorners>& values) {
    std::size_t next = 0;
    for (int corner = 0; corner < pixels_.corners(); ++corner)
      if (usable(corner)) sorted[next++] = values[static_cast<std::size_t>(corner)];
    std::nth_element(sorted.begin(), sorted.begin() + count / 2, sorted.begin() + count);
    return sorted[static_cast<std::size_t>(count / 2)];
  };
  const double most = alike ? most_misfit : ratio * median(misfit),
               least = alike ? least_contrast : kOccludedContrast * median(contrast);
  bool changed = false;
  // Corners that fit with fewer pixels are not seen better.
  const bool returns = may_return && !run_->light.beside_hidden;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!usable(corner) || !(used(corner) || returns)) continue;
    const std::size_t i = static_cast<std::size_t>(corner);
    const Hidden now = misfit[i] <= most ? contrast[i] >= least ? Hidden::kNot : Hidden::kFlat : Hidden::kMisfit;
    changed |= (now == Hidden::kNot) != used(corner);
    run_->visibility.Set(corner, now);
  }
  return changed;
}

CornerFlags BoardFit::Occluded() const {
  CornerFlags occluded{};
  for (int corner = 0; corner < corners(); ++corner)
    occluded[static_cast<std::size_t>(corner)] = usable(corner) && !used(corner);
  return occluded;
}

BoardFit::HiddenNeighbours BoardFit::HiddenBeside(int corner, int axis) const {
  const int cols = run_->view.size.cols - 1, rows = run_->view.size.rows - 1;
  const int at = axis == 0 ? corner % cols : corner / cols, count = axis == 0 ? cols : rows,
            next = axis == 0 ? 1 : cols;
  const auto hidden = [&](int other) { return pixels_.inside(other) && !used(other); };
  return {at > 0 && hidden(corner - next), at + 1 < count && hidden(corner + next)};
}

bool BoardFit::AnyBesideHidden() const {
  if (!AnyUnused()) return false;
  for (int corner = 0; corner < corners(); ++corner)
    if (used(corner) && LiesBesideHidden(corner)) return true;
  return false;
}

WindowEnds BoardFit::EndsOf(int corner, int axis) const {
  const CornerPlace& place = pixels_.place(corner);
  WindowEnds ends = place.ends[static_cast<std::size_t>(axis)];
  if (!run_->light.beside_hidden || !used(corner)) return ends;
  const HiddenNeighbours hidden = HiddenBeside(corner, axis);
  if (!hidden.any()) return ends;
  if (!ends.any()) ends.slope = 1 / (kFadePx * place.board_by_pixel.row(axis).norm());
  if (hidden.before) ends.low = std::max(ends.low, -kReachToHidden);
  if (hidden.after) ends.high = std::min(ends.high, kReachToHidden);
  return ends;
}

void BoardFit::SetWindows() {
  for (int corner = 0; corner < corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    for (int axis = 0; axis < 2; ++axis) {
      const WindowEnds ends = EndsOf(corner, axis);
      const auto set = [&](int which, double value) {
        std::fill_n(pixels_.lanes().parameter_data(which + axis) + pixels_.Lane(corner), 4, static_cast<float>(value));
      };
      set(LaneBlock::kFadeX, ends.slope);
      set(LaneBlock::kMiddleX, ends.middle());
      set(LaneBlock::kPeakX, ends.peak());
    }
  }
}

CornerFlags BoardFit::OffBy(double ratio) const {
  CornerFlags off{};
  std::array<double, kMaxCorners> misfits;
  std::ptrdiff_t count = 0;
  for (int corner = 0; corner < corners(); ++corner)
    if (used(corner)) misfits[static_cast<std::size_t>(count++)] = misfit(corner);
  if (count == 0) return off;
  std::nth_element(misfits.begin(), misfits.begin() + count / 2, misfits.begin() + count);
  const double most = ratio * misfits[static_cast<std::size_t>(count / 2)];
  for (int corner = 0; corner < corners(); ++corner)
    off[static_cast<std::size_t>(corner)] = used(corner) && misfit(corner) > most;
  return off;
}

CornerFlags BoardFit::Pulled() const {
  if (!AnyUnused()) return {};
  CornerFlags pulled = OffBy(kPulledRatio);
  for (int corner = 0; corner < corners(); ++corner)
    if (!LiesBesideHidden(corner)) pulled[static_cast<std::size_t>(corner)] = false;
  return pulled;
}

void BoardFit::TellDoubt() {
  const std::span<const Hidden> cells = run_->result.visibility.cells();
  Visibility seen = run_->visibility;
  seen.ShowCellsByAnyCorner();
  bool doubtful = AnyOf(OffBy(kOccludedRatio));
  for (std::size_t cell = 0; cell < cells.size(); ++cell) doubtful |= cells[cell] == Hidden::kNot && !seen.Shows(cell);
  run_->result.doubtful = doubtful;
}

}  // namespace chequer
