#include "lens/print_stretch.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace chequer {
namespace {

/// So far that rounding vanishes in what it makes of the cost, so near that the cost is a parabola.
constexpr double kStep = 0.002;
constexpr double kLeastStretch = 1e-3, kLeastDeviations = 4;

double CostOf(std::span<const LensView> views, Bundle bundle) {
  std::size_t points = 0;
  for (const LensView& view : views) points += view.points.size();
  const double rms_px = FitBundle(views, {.bends = true}, bundle).rms_px;
  return rms_px * rms_px * static_cast<double>(points);
}

}  // namespace

bool PrintStretch::matters() const { return std::abs(stretch) > std::max(kLeastStretch, kLeastDeviations * deviation); }

std::vector<LensView> Stretched(std::span<const LensView> views, double stretch) {
  std::vector<LensView> stretched(views.begin(), views.end());
  for (LensView& view : stretched)
    for (SeenPoint& point : view.points) point.on_board_m.y() *= 1 + stretch;
  return stretched;
}

PrintStretch FindPrintStretch(std::span<const LensView> views, const Bundle& bundle, const BundleFit& fit) {
  std::size_t points = 0;
  for (const LensView& view : views) points += view.points.size();
  const double here = fit.rms_px * fit.rms_px * static_cast<double>(points);
  const double lower = CostOf(Stretched(views, -kStep), bundle), taller = CostOf(Stretched(views, kStep), bundle);
  const double curvature = (lower - 2 * here + taller) / (kStep * kStep);
  if (!(curvature > 0)) return {0, 1};
  PrintStretch found;
  found.stretch = (lower - taller) / (2 * kStep * curvature);
  // What the points leave, two coordinates each; of χ², half the curvature is the information.
  const double variance = here / std::max(2 * static_cast<double>(points), 1.0);
  found.deviation = std::sqrt(2 * variance / curvature);
  return found;
}

}  // namespace chequer
