// Of PhotometricFit: boards without the corners that something hides.
#include <algorithm>
#include <optional>

#include "detect/fit/fit.h"

namespace chequer {
namespace {

/// How often corners that turn out to be occluded are left out, each time from the start; once from a rough fit, which
/// goes on without them.
constexpr int kMostLeftOut = 4;
/// Of the worst occluded corner's misfit: corners with less of it may be but pulled by those with more.
constexpr double kWorstOccluded = 0.25;
/// A side whose corners fit so much worse than the opposite one's may be covered.
constexpr double kCoveredSide = 4;

/// The corners of the side that fits worst, if it fits much worse than the opposite one.
std::optional<CornerFlags> WorstSide(const BoardFit& fit, MarkerSize size) {
  const int rows = size.rows - 1, cols = size.cols - 1;
  const auto misfit_of = [&](int first, int step, int count) {
    double sum = 0;
    for (int i = 0; i < count; ++i) {
      const int corner = first + i * step;
      if (fit.usable(corner)) sum += fit.misfit(corner);
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
  CornerFlags side{};
  for (int i = 0; i < worst.count; ++i) side[static_cast<std::size_t>(worst.first + i * worst.step)] = true;
  return side;
}

}  // namespace

bool PhotometricFit::LeaveOutWorstOccluded() {
  const CornerFlags occluded = fit_.Occluded();
  double worst = 0;
  for (int corner = 0; corner < fit_.corners(); ++corner)
    if (occluded[static_cast<std::size_t>(corner)]) worst = std::max(worst, fit_.misfit(corner));
  bool any = false;
  for (int corner = 0; corner < fit_.corners(); ++corner) {
    const std::size_t i = static_cast<std::size_t>(corner);
    if (!occluded[i] || fit_.misfit(corner) < kWorstOccluded * worst) continue;
    choice_.left_out[i] = any = true;
  }
  return any;
}

void PhotometricFit::LeaveOutOccluded(const Task& task) {
  const int most = fit_.rough() ? 1 : kMostLeftOut;
  for (int times = 0; times < most; ++times) {
    if (!LeaveOutWorstOccluded()) return;
    Keep(before_);
    choice_.from = fit_.looks_farther() ? &before_.run : nullptr;
    if (Refit(task)) continue;
    fit_.Restore(before_.run);
    return;
  }
}

void PhotometricFit::LeaveOutPulled(const Task& task) {
  if (fit_.looks_farther() || !fit_.result().flat()) return;
  const CornerFlags pulled = fit_.Pulled();
  if (!AnyOf(pulled)) return;
  Keep(before_);
  for (std::size_t corner = 0; corner < pulled.size(); ++corner) choice_.left_out[corner] |= pulled[corner];
  if (Refit(task))
    fit_.RestoreCells(before_.run.result);
  else
    Restore(before_);
}

bool PhotometricFit::LeaveOutSide(const Task& task) {
  const std::optional<CornerFlags> side = WorstSide(fit_, task.start.size);
  if (!side) return false;
  Keep(before_);
  for (std::size_t corner = 0; corner < side->size(); ++corner) choice_.left_out[corner] |= (*side)[corner];
  if (Refit(task) && BetterThan(before_, Hypothesis::kCoveredSide)) {
    LeaveOutOccluded(task);
    return true;
  }
  Restore(before_);
  return false;
}

}  // namespace chequer
