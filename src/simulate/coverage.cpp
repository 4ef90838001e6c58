#include "simulate/coverage.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Integral up to t of the part of an edge (spread evenly over low … high) that lies left of a point: what a unit of
/// height covers of everything left of t.
double CoveredUpTo(double t, double low, double high) {
  if (t <= low) return 0;
  if (t >= high) return t - 0.5 * (low + high);
  return 0.5 * (t - low) * (t - low) / (high - low);
}

}  // namespace

void CoverageRaster::Reset(int width, int height) {
  width_ = width;
  height_ = height;
  cells_.assign(static_cast<std::size_t>(height) * static_cast<std::size_t>(width + 2), Eigen::Array4f::Zero());
}

void CoverageRaster::Add(const OutlineEdge& edge, const Eigen::Vector2d& origin, double scale) {
  const Eigen::Vector2d a = (edge.from - origin) * scale;
  const Eigen::Vector2d b = (edge.to - origin) * scale;
  if (a.y() == b.y() || std::max(a.y(), b.y()) <= 0 || std::min(a.y(), b.y()) >= height_) return;
  // Pieces left of the raster cover whole rows and pieces right of it nothing, so they are cut off there and moved onto
  // its rim.
  double cuts[4] = {0, 1, 1, 1};
  int pieces = 1;
  if (a.x() != b.x()) {
    double at[2] = {(0 - a.x()) / (b.x() - a.x()), (width_ - a.x()) / (b.x() - a.x())};
    if (at[0] > at[1]) std::swap(at[0], at[1]);
    for (const double t : at)
      if (t > 0 && t < 1) cuts[pieces++] = t;
    cuts[pieces] = 1;
  }
  const auto on_rim = [&](double x) { return std::clamp(x, 0.0, static_cast<double>(width_)); };
  for (int i = 0; i < pieces; ++i) {
    const Eigen::Vector2d p = a + cuts[i] * (b - a);
    const Eigen::Vector2d q = a + cuts[i + 1] * (b - a);
    AddClipped(on_rim(p.x()), p.y(), on_rim(q.x()), q.y(), edge.weight);
  }
}

void CoverageRaster::AddClipped(double x0, double y0, double x1, double y1, const Eigen::Array4f& weight) {
  if (y0 == y1) return;
  const double sign = y1 > y0 ? 1 : -1;
  if (sign < 0) {
    std::swap(x0, x1);
    std::swap(y0, y1);
  }
  const double slope = (x1 - x0) / (y1 - y0);
  const double top = std::max(y0, 0.0);
  const double bottom = std::min(y1, static_cast<double>(height_));
  const int last = std::min(height_ - 1, static_cast<int>(std::ceil(bottom)) - 1);
  for (int row = static_cast<int>(top); row <= last; ++row) {
    const double from = std::max(top, static_cast<double>(row));
    const double to = std::min(bottom, static_cast<double>(row + 1));
    const auto x_at = [&](double y) { return std::clamp(x0 + slope * (y - y0), std::min(x0, x1), std::max(x0, x1)); };
    AddInRow(row, x_at(from), x_at(to), sign * (to - from), weight);
  }
}

void CoverageRaster::AddInRow(int row, double x0, double x1, double dy, const Eigen::Array4f& weight) {
  const double low = std::min(x0, x1);
  const double high = std::max(x0, x1);
  Eigen::Array4f* cells = &cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_ + 2)];
  const int first = static_cast<int>(low);
  const int last = static_cast<int>(high) + 1;
  double before = 0;
  double covered = 0;
  for (int x = first; x <= last; ++x) {
    const double up_to = CoveredUpTo(x + 1, low, high);
    const double here = up_to - covered;
    cells[std::min(x, width_ + 1)] += static_cast<float>(dy * (here - before)) * weight;
    before = here;
    covered = up_to;
  }
}

std::span<const Eigen::Array4f> CoverageRaster::IntegrateRow(int y) {
  Eigen::Array4f* cells = &cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_ + 2)];
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int x = 0; x < width_; ++x) {
    sum += cells[x];
    cells[x] = sum;
  }
  return {cells, static_cast<std::size_t>(width_)};
}

}  // namespace chequer
