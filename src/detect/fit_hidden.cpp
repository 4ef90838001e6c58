// Of PhotometricFit: corners that something hides.
#include <algorithm>
#include <functional>

#include "detect/fit.h"

namespace chequer {
namespace {

/// A corner whose pixels disagree so much more than the median corner's is hidden.
constexpr double kHiddenRatio = 8;
/// Corners with less of the median corner's contrast are hidden too.
constexpr double kHiddenContrast = 0.2;
/// How often corners that turn out to be hidden are left out, each time from the start.
constexpr int kMostLeftOut = 4;
/// Of the worst hidden corner's misfit: corners with less of it may be but pulled by those with more.
constexpr double kWorstHidden = 0.25;
/// A side whose corners fit so much worse than the opposite one's may be covered; the board is then so much clearer
/// without it.
constexpr double kCoveredSide = 4, kClearerBySide = 2;

}  // namespace

PhotometricFit::QuadrantLight PhotometricFit::LightAround(int corner) const {
  const std::size_t phase = red_phase_ < 0 ? 0 : static_cast<std::size_t>(red_phase_ ^ 1);
  const int cell = pixels_.Cell(corner);
  const QuadrantLevels quadrants = LevelsOf(corner);
  const auto level = [&](std::size_t i) { return double{levels_[static_cast<std::size_t>(quadrants[i])][phase]}; };
  const double along = level(0) + level(3), across = level(1) + level(2);
  return IsDark(cell / size_.cols, cell % size_.cols) ? QuadrantLight{across, along} : QuadrantLight{along, across};
}

double PhotometricFit::Contrast(int corner) const {
  const QuadrantLight around = LightAround(corner);
  return (around.light - around.dark) / 2;
}

double PhotometricFit::Misfit(int corner) const {
  const LaneBlock& lanes = pixels_.lanes();
  double square = 0, pixels = 0;
  for (int phase = 0; phase < 4; ++phase) {
    const int lane = pixels_.Lane(corner) + phase;
    square += lanes.sum(ProductSum(kResidual, kResidual), lane);
    pixels += lanes.count(lane);
  }
  return pixels > 0 ? square / pixels : 1e9;
}

bool PhotometricFit::FindHiddenCorners() {
  std::array<double, kMaxCorners> misfit, contrast, sorted;
  double least_misfit = 1e9, most_misfit = 0, least_contrast = 1e9, most_contrast = -1e9;
  int count = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!usable_[static_cast<std::size_t>(corner)]) continue;
    const std::size_t i = static_cast<std::size_t>(corner);
    misfit[i] = Misfit(corner);
    contrast[i] = Contrast(corner);
    least_misfit = std::min(least_misfit, misfit[i]);
    most_misfit = std::max(most_misfit, misfit[i]);
    least_contrast = std::min(least_contrast, contrast[i]);
    most_contrast = std::max(most_contrast, contrast[i]);
    ++count;
  }
  misfit_spread_ = most_misfit / std::max(least_misfit, 1e-9);
  // Corners that are all alike are all near the median one.
  const bool alike = least_contrast >= kHiddenContrast * most_contrast && most_misfit <= kHiddenRatio * least_misfit;
  const auto median = [&](const std::array<double, kMaxCorners>& values) {
    std::size_t next = 0;
    for (int corner = 0; corner < pixels_.corners(); ++corner)
      if (usable_[static_cast<std::size_t>(corner)]) sorted[next++] = values[static_cast<std::size_t>(corner)];
    std::nth_element(sorted.begin(), sorted.begin() + count / 2, sorted.begin() + count);
    return sorted[static_cast<std::size_t>(count / 2)];
  };
  const double most = alike ? most_misfit : kHiddenRatio * median(misfit),
               least = alike ? least_contrast : kHiddenContrast * median(contrast);
  bool changed = false;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    bool& used = used_[static_cast<std::size_t>(corner)];
    const bool now = usable_[static_cast<std::size_t>(corner)] && misfit[static_cast<std::size_t>(corner)] <= most &&
                     contrast[static_cast<std::size_t>(corner)] >= least;
    changed |= now != used;
    used = now;
  }
  return changed;
}

bool PhotometricFit::LeaveOutWorstHidden() {
  const auto hidden = [&](int corner) {
    return usable_[static_cast<std::size_t>(corner)] && !used_[static_cast<std::size_t>(corner)];
  };
  double worst = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    if (hidden(corner)) worst = std::max(worst, Misfit(corner));
  bool any = false;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!hidden(corner) || Misfit(corner) < kWorstHidden * worst) continue;
    left_out_[static_cast<std::size_t>(corner)] = any = true;
  }
  return any;
}

void PhotometricFit::LeaveOutHidden(const LightReader& reader, const Lens& lens, const Start& start) {
  for (int times = 0; times < kMostLeftOut; ++times) {
    if (!LeaveOutWorstHidden()) return;
    before_ = result_;
    if (FitAnew(reader, lens, start)) continue;
    result_ = before_;
    return;
  }
}

std::optional<std::array<bool, kMaxCorners>> PhotometricFit::WorstSide() const {
  const int rows = size_.rows - 1, cols = size_.cols - 1;
  const auto misfit_of = [&](int first, int step, int count) {
    double sum = 0;
    for (int i = 0; i < count; ++i) {
      const int corner = first + i * step;
      if (usable_[static_cast<std::size_t>(corner)]) sum += Misfit(corner);
    }
    return sum;
  };
  struct Side {
    int first, step, count;
    double over_opposite;
  } worst{};
  const auto compare = [&](int step, int count, int to_opposite) {
    const double here = misfit_of(0, step, count), opposite = misfit_of(to_opposite, step, count);
    if (here > worst.over_opposite * opposite) worst = {0, step, count, here / opposite};
    if (opposite > worst.over_opposite * here) worst = {to_opposite, step, count, opposite / here};
  };
  compare(1, cols, (rows - 1) * cols);
  compare(cols, rows, cols - 1);
  if (worst.over_opposite < kCoveredSide) return std::nullopt;
  std::array<bool, kMaxCorners> side{};
  for (int i = 0; i < worst.count; ++i) side[static_cast<std::size_t>(worst.first + i * worst.step)] = true;
  return side;
}

bool PhotometricFit::LeaveOutSide(const LightReader& reader, const Lens& lens, const Start& start) {
  const auto side = WorstSide();
  if (!side) return false;
  const std::array<bool, kMaxCorners> left_out_before = left_out_;
  before_ = result_;
  for (std::size_t corner = 0; corner < side->size(); ++corner) left_out_[corner] |= (*side)[corner];
  if (FitAnew(reader, lens, start) && result_.signal_to_noise > kClearerBySide * before_.signal_to_noise) {
    LeaveOutHidden(reader, lens, start);
    return true;
  }
  left_out_ = left_out_before;
  result_ = before_;
  if (!FitAnew(reader, lens, start)) result_ = before_;
  return false;
}

bool PhotometricFit::AnyHidden() const {
  return std::any_of(used_.begin(), used_.begin() + pixels_.corners(), [](bool used) { return !used; });
}

void PhotometricFit::FindHiddenCells() {
  std::array<bool, kMaxCorners> unused;
  std::transform(used_.begin(), used_.end(), unused.begin(), std::logical_not());
  hidden_cells_.assign(static_cast<std::size_t>(size_.rows * size_.cols), 0);
  HideCellsBeside(unused);
}

void PhotometricFit::HideCellsBeside(const std::array<bool, kMaxCorners>& corners) {
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!corners[static_cast<std::size_t>(corner)]) continue;
    for (const int cell : LevelsAround(size_, corner, false)) hidden_cells_[static_cast<std::size_t>(cell)] = 1;
  }
}

}  // namespace chequer
