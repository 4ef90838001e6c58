#include "lens/edge_width.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace chequer {
namespace {

constexpr double kStepPx = 0.5;
/// An edge with less contrast, grey levels, is measured too badly.
constexpr double kLeastContrast = 20;
/// Profiles reach this share of a cell to both sides, so that they stay within the two cells.
constexpr double kReach = 0.4;

/// Width of the edge that crosses the line from `from` to `to` in its middle, measured along the normal.
std::optional<double> WidthBetween(const DetectionPlane& plane, const Eigen::Vector2d& from,
                                   const Eigen::Vector2d& to) {
  const Eigen::Vector2d along = to - from;
  const double length = along.norm(), reach = kReach * length;
  if (!(length > 4)) return std::nullopt;
  const Eigen::Vector2d normal(-along.y() / length, along.x() / length);
  const Eigen::Vector2d middle = (from + to) / 2 - Eigen::Vector2d::Constant(plane.offset_px);
  std::vector<double> profile;
  for (double at = -reach; at <= reach; at += kStepPx) {
    const Eigen::Vector2d p = middle + at * normal;
    if (!(p.x() >= 0 && p.y() >= 0 && p.x() <= plane.plane.width() - 1 && p.y() <= plane.plane.height() - 1))
      return std::nullopt;
    profile.push_back(plane.plane.Bilinear(static_cast<float>(p.x()), static_cast<float>(p.y())));
  }
  const double contrast = std::abs(profile.back() - profile.front());
  double steepest = 0;
  // Over a pixel: noise of single pixels is no slope.
  for (std::size_t i = 2; i < profile.size(); ++i)
    steepest = std::max(steepest, std::abs(profile[i] - profile[i - 2]) / (2 * kStepPx));
  if (contrast < kLeastContrast || !(steepest > 0)) return std::nullopt;
  return contrast / steepest;
}

}  // namespace

double EdgeWidthPx(const DetectionPlane& plane, std::span<const std::optional<Eigen::Vector2d>> corners, int rows,
                   int cols) {
  std::vector<double> widths;
  const auto at = [&](int row, int col) { return corners[static_cast<std::size_t>(row * cols + col)]; };
  const auto add = [&](const std::optional<Eigen::Vector2d>& a, const std::optional<Eigen::Vector2d>& b) {
    if (!a || !b) return;
    if (const auto width = WidthBetween(plane, *a, *b)) widths.push_back(*width);
  };
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      if (col + 1 < cols) add(at(row, col), at(row, col + 1));
      if (row + 1 < rows) add(at(row, col), at(row + 1, col));
    }
  if (widths.empty()) return 0;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return *middle;
}

}  // namespace chequer
