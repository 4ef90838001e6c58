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
  const int pixels_of_corner = pixels_.pixels(pixels_.corners() / 2);
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
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!usable(corner) || !(used(corner) || may_return)) continue;
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

CornerFlags BoardFit::Pulled() const {
  CornerFlags pulled{};
  if (!AnyUnused()) return pulled;
  std::array<double, kMaxCorners> misfits;
  std::ptrdiff_t count = 0;
  for (int corner = 0; corner < corners(); ++corner)
    if (used(corner)) misfits[static_cast<std::size_t>(count++)] = misfit(corner);
  if (count == 0) return pulled;
  std::nth_element(misfits.begin(), misfits.begin() + count / 2, misfits.begin() + count);
  const double most = kPulledRatio * misfits[static_cast<std::size_t>(count / 2)];
  const int cols = run_->view.size.cols - 1;
  const auto hidden = [&](int other) { return pixels_.inside(other) && !used(other); };
  for (int corner = 0; corner < corners(); ++corner) {
    const int col = corner % cols;
    const bool beside = (col > 0 && hidden(corner - 1)) || (col + 1 < cols && hidden(corner + 1)) ||
                        (corner >= cols && hidden(corner - cols)) ||
                        (corner + cols < corners() && hidden(corner + cols));
    pulled[static_cast<std::size_t>(corner)] = used(corner) && beside && misfit(corner) > most;
  }
  return pulled;
}

}  // namespace chequer
