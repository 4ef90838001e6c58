#include "detect/fit/shading.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>

namespace chequer {
namespace {

/// Levels that say something: not black, not saturated.
constexpr float kLeastLevel = 1e-4f, kMostLevel = 0.97f;
/// A steeper gradient, per cell, is no shading: something lies over the board.
constexpr double kMostPerCell = 0.2;
/// The same for one that may be bent.
constexpr double kMostPerCellBent = 0.5;
/// A bent shading is tried where the slope is steeper than that per cell and the spread about it, as a share of the
/// light, larger than what noise leaves in levels.
constexpr double kSteep = 0.03, kUneven = 0.007;
/// The spread of the light cells about a slope, as a share of the light. Where it is smaller, noise explains it, and of
/// cells that are not fine the second order is not looked for. (Measured: with .003, boards in even light ask in vain,
/// in 2 % of a frame's instructions, and squared errors in flicker are 3 % smaller.)
constexpr double kQuiet = 0.005;
/// Either has to explain all but this of the slope's sum of squares.
constexpr double kBentLeaves = 0.25;
/// A bent shading falls no lower, as a share of the light at the centre.
constexpr double kLeastLight = 0.05;
constexpr int kSteps = 4;
/// Degrees of freedom, of the offsets and five terms, that leave the second order something to be told from.
constexpr double kFewestOfFine = 10;
/// A weak shading bends no more, of the logarithm, per cell².
constexpr double kMostBend = 0.03;

/// Sums of a linear regression with an offset of its own, over kTerms terms.
template <int kTerms>
struct Group {
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using Products = Eigen::Matrix<double, kTerms, kTerms>;

  double n = 0, value = 0, value_square = 0;
  Terms terms = Terms::Zero(), by_value = Terms::Zero();
  Products products = Products::Zero();

  void Add(const Terms& at, double v) {
    n += 1;
    value += v;
    value_square += v * v;
    terms += at;
    by_value += v * at;
    products += at * at.transpose();
  }
};

/// Least squares over groups of cells, the offsets eliminated.
template <int kTerms>
struct Regression {
  using Sums = Group<kTerms>;

  typename Sums::Products normal = Sums::Products::Zero();
  typename Sums::Terms right = Sums::Terms::Zero();
  double square = 0;  ///< of the values about their groups' means
  double freedom = 0;

  void Add(const Sums& g) {
    if (g.n < 4) return;
    normal += g.products - g.terms * g.terms.transpose() / g.n;
    right += g.by_value - g.terms * g.value / g.n;
    square += g.value_square - g.value * g.value / g.n;
    freedom += g.n - 1;
  }
};

/// Calls add(saturation, x, y, level) for the light cells that tell of a phase.
template <class Visit>
void VisitCells(const ShadedCells& cells, int phase, const Visit& visit) {
  for (int row = 0; row < cells.size.rows; ++row)
    for (int col = IsDark(row, 0) ? 1 : 0; col < cells.size.cols; col += 2) {
      const std::size_t cell = static_cast<std::size_t>(row * cells.size.cols + col);
      if (cells.saturated[cell] && phase == cells.blue_phase) continue;
      if (!cells.occluded.empty() && cells.occluded[cell]) continue;
      const float level = cells.levels[cell][static_cast<std::size_t>(phase)];
      if (level < kLeastLevel || level > kMostLevel) continue;
      visit(cells.saturated[cell] != 0, col + 0.5 - 0.5 * cells.size.cols, row + 0.5 - 0.5 * cells.size.rows, level);
    }
}

/// terms(x, y) are a cell's, value(x, y, level) what they are to explain.
template <int kTerms, class Terms, class Value>
Regression<kTerms> Regress(const ShadedCells& cells, const Terms& terms, const Value& value) {
  Regression<kTerms> regression;
  for (int phase = 0; phase < cells.phases; ++phase) {
    // The two phases of green have the same levels.
    const bool mosaic = cells.blue_phase >= 0, both_green = mosaic && phase == (cells.blue_phase ^ 1);
    if (mosaic && phase == (cells.blue_phase ^ 2)) continue;
    std::array<Group<kTerms>, 2> groups;  // by saturation
    VisitCells(cells, phase, [&](bool saturated, double x, double y, float level) {
      groups[saturated].Add(terms(x, y), value(x, y, level));
    });
    for (const Group<kTerms>& group : groups) regression.Add(group);
    if (both_green)
      for (const Group<kTerms>& group : groups) regression.Add(group);
  }
  return regression;
}

using Bent = Eigen::Matrix<double, 5, 1>;

Bent Powers(double x, double y) { return (Bent() << x, y, x * x, x * y, y * y).finished(); }

double LightOf(const Bent& bent, double x, double y) { return 1 + bent.dot(Powers(x, y)); }

bool IsLight(const Bent& bent, MarkerSize size) {
  for (const double x : {-0.5, 0.0, 0.5})
    for (const double y : {-0.5, 0.0, 0.5})
      if (!(LightOf(bent, x * size.cols, y * size.rows) > kLeastLight)) return false;
  return true;
}

/// A slope and the second order of the light's logarithm. Nothing where the cells hardly tell them, or too steep ones,
/// or if they leave more than `most_square`.
std::optional<Shading> FindWeak(const ShadedCells& cells, double most_square) {
  const auto regression =
      Regress<5>(cells, Powers, [](double, double, float level) { return double{std::log(level)}; });
  if (regression.freedom < kFewestOfFine) return std::nullopt;
  const Eigen::LLT<Eigen::Matrix<double, 5, 5>> solver(regression.normal);
  if (solver.info() != Eigen::Success) return std::nullopt;
  const Bent weak = solver.solve(regression.right);
  if (!weak.allFinite() || weak.head<2>().norm() > kMostPerCell || weak.tail<3>().norm() > kMostBend)
    return std::nullopt;
  if (regression.square - weak.dot(regression.right) > most_square) return std::nullopt;
  return Shading{weak.head<2>(), weak.tail<3>(), false};
}

/// Gauss and Newton's descent from the slope. Nothing if it leaves more than `most_square`.
std::optional<Shading> FindBent(const ShadedCells& cells, const Eigen::Vector2d& slope, double most_square) {
  Bent bent;
  bent << slope, slope.x() * slope.x() / 2, slope.x() * slope.y(), slope.y() * slope.y() / 2;
  for (int step = 0; step <= kSteps; ++step) {
    if (!bent.allFinite() || !IsLight(bent, cells.size)) return std::nullopt;
    const auto regression = Regress<5>(
        cells, [&](double x, double y) -> Bent { return Powers(x, y) / LightOf(bent, x, y); },
        [&](double x, double y, float level) { return double{std::log(level)} - std::log(LightOf(bent, x, y)); });
    if (step == kSteps) {
      if (regression.square > most_square || bent.head<2>().norm() > kMostPerCellBent) return std::nullopt;
      return Shading{bent.head<2>(), bent.tail<3>(), true};
    }
    const Eigen::LLT<Eigen::Matrix<double, 5, 5>> solver(regression.normal);
    if (regression.freedom < 10 || solver.info() != Eigen::Success) return std::nullopt;
    bent += solver.solve(regression.right);
  }
  return std::nullopt;
}

}  // namespace

std::optional<Shading> FindShading(const ShadedCells& cells) {
  const auto regression = Regress<2>(
      cells, [](double x, double y) { return Eigen::Vector2d(x, y); },
      [](double, double, float level) { return double{std::log(level)}; });
  if (!(regression.normal.determinant() > 1)) return std::nullopt;
  const Eigen::Vector2d slope = regression.normal.inverse() * regression.right;
  if (!slope.allFinite()) return std::nullopt;
  const double square = regression.square - slope.dot(regression.right);
  if (slope.norm() > kSteep && square > kUneven * kUneven * regression.freedom)
    if (const auto bent = FindBent(cells, slope, kBentLeaves * square)) return bent;
  if (cells.fine || square > kQuiet * kQuiet * regression.freedom)
    if (const auto weak = FindWeak(cells, cells.fine ? std::numeric_limits<double>::infinity() : kBentLeaves * square))
      return weak;
  if (slope.norm() > kMostPerCell) return std::nullopt;
  return Shading{slope, Eigen::Vector3d::Zero(), false};
}

}  // namespace chequer
