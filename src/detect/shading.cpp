#include "detect/shading.h"

#include <Eigen/LU>
#include <cmath>

namespace chequer {
namespace {

/// Levels that say something: not black, not saturated.
constexpr float kLeastLevel = 1e-4f, kMostLevel = 0.97f;
/// A steeper gradient, per cell, is no shading: something lies over the board.
constexpr double kMostPerCell = 0.2;

/// Sums of a linear regression with an offset of its own.
struct Group {
  double n = 0, x = 0, y = 0, value = 0, xx = 0, xy = 0, yy = 0, x_value = 0, y_value = 0;

  void Add(double at_x, double at_y, double v) {
    n += 1, x += at_x, y += at_y, value += v;
    xx += at_x * at_x, xy += at_x * at_y, yy += at_y * at_y;
    x_value += at_x * v, y_value += at_y * v;
  }
};

}  // namespace

std::optional<Eigen::Vector2d> FindShading(MarkerSize size, std::span<const PhaseValues> levels,
                                           std::span<const std::uint8_t> saturated, int phases, int blue_phase) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (int phase = 0; phase < phases; ++phase) {
    std::array<Group, 2> groups;  // by saturation
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        if (IsDark(row, col)) continue;
        const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
        if (saturated[cell] && phase == blue_phase) continue;
        const float level = levels[cell][static_cast<std::size_t>(phase)];
        if (level < kLeastLevel || level > kMostLevel) continue;
        groups[saturated[cell] != 0].Add(col + 0.5 - 0.5 * size.cols, row + 0.5 - 0.5 * size.rows,
                                         std::log(static_cast<double>(level)));
      }
    for (const Group& g : groups) {
      if (g.n < 4) continue;
      normal(0, 0) += g.xx - g.x * g.x / g.n;
      normal(0, 1) += g.xy - g.x * g.y / g.n;
      normal(1, 1) += g.yy - g.y * g.y / g.n;
      right += Eigen::Vector2d(g.x_value - g.x * g.value / g.n, g.y_value - g.y * g.value / g.n);
    }
  }
  normal(1, 0) = normal(0, 1);
  if (!(normal.determinant() > 1)) return std::nullopt;
  const Eigen::Vector2d per_cell = normal.inverse() * right;
  if (!per_cell.allFinite() || per_cell.norm() > kMostPerCell) return std::nullopt;
  return per_cell;
}

}  // namespace chequer
