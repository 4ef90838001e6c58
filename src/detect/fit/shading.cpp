#include "detect/fit/shading.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/small_cholesky.h"

namespace chequer {
namespace {

/// Levels that say something: not black, not saturated.
constexpr float kLeastLevel = 1e-4f, kMostLevel = 0.97f;
/// A steeper gradient, per cell, is no shading: something lies over the board.
constexpr double kMostPerCell = 0.2;
/// The same for one that may be bent.
constexpr double kMostPerCellBent = 0.5;
/// A bent shading is tried where the slope is steeper than that per cell and it can explain all but the last of the sum
/// of squares, which it has to: by the third order of its logarithm, of which a slope and a second order leave 3.3
/// times as much for each of six cells (reckoned, along one axis), and less than so many times (a guess).
constexpr double kSteep = 0.03, kLeftOfThird = 9, kBentLeaves = 0.25;
/// A bent shading falls no lower, as a share of the light at the centre.
constexpr double kLeastLight = 0.05;
constexpr int kSteps = 4;
/// Degrees of freedom, of the offsets and five terms, that leave the second order something to be told from.
constexpr double kFewestOfBend = 10;
/// A weak shading bends no more, of the logarithm, per cell².
constexpr double kMostBend = 0.03;
/// Except in fine cells, a slope that is less steep, per cell, moves a pose by less than a fifth of its deviation (of
/// 10 px cells blurred by 0.8 px, edges by 0.002 px). Told from few levels, it would move it as much by its noise,
/// otherwise in each frame (measured: poses with and without memory differed by 0.13 instead of 0.09 deviations).
constexpr double kWeakSlope = 0.003;
/// A second order whose square over its variance is less may be noise: 2 of 100 boards without one have more (χ² of
/// 3), and as many where few degrees of freedom tell that variance, if it is so much over them more (F distribution).
constexpr double kBendByChance = 9.8, kOverFreedom = 5.5;
/// Levels are no surer than that: rounding.
constexpr double kSurestLevel = 1e-5;

/// Of the light cells: the standard deviation of veils, the most of one, and the least by which cells of one ink
/// differ; those that differ by more than the last are not what they seem to be (guesses).
constexpr double kUsualVeil = 0.1, kMostVeil = 0.6, kLeastOfLevel = 0.001, kMostOfLevel = 0.05;
/// One that is so much lighter than the darkest ink is none: something lies over cells (a guess).
constexpr double kAboveDarkest = 1.1;
/// So many standard deviations of a veil are shrunk to nothing (James and Stein), and stronger ones by less: most
/// cameras have none, and a wrong one of a hundredth moves a board in steep light by a third of its deviation
/// (measured).
constexpr double kCertainVeil = 3;
/// By how much veils differ between the channels: a share of the veil, and of the light cells at least (guesses).
constexpr double kVeilTint = 0.15, kLeastTint = 0.002;
/// Dark cells of an ink that tell a slope.
constexpr int kFewestDark = 4;

/// The spread of the light cells of one ink from which on some may be of the other, as a share of the light: one of
/// eighteen cells makes .07 (reckoned). It then takes the slope along: by up to .06 per cell of boards in even light,
/// by 63 squares of the pose's standard deviation (measured, of boards that a camera's motion has blurred).
constexpr double kMisread = 0.04;
/// Inks whose light cells differ by less in what they send of blue are not told apart by it, as a share of white's.
constexpr float kLeastApart = 0.25f;

double Square(double value) { return value * value; }

constexpr int kLightTerms = 5;
using LightTerms = Eigen::Matrix<double, kLightTerms, 1>;

LightTerms Powers(double x, double y) { return (LightTerms() << x, y, x * x, x * y, y * y).finished(); }

/// What explains a cell's level in all phases: 1, the terms, and the lower triangle of the terms' products.
struct CellTerms {
  static constexpr int kFirstProduct = 1 + kLightTerms;
  /// Whole vectors of doubles: the last value is not used.
  Eigen::Matrix<double, kFirstProduct + kLightTerms*(kLightTerms + 1) / 2 + 1, 1> values;

  explicit CellTerms(const LightTerms& terms) {
    values[0] = 1, values[values.size() - 1] = 0;
    values.segment<kLightTerms>(1) = terms;
    for (int row = 0, at = kFirstProduct; row < kLightTerms; ++row)
      for (int col = 0; col <= row; ++col) values[at++] = terms[row] * terms[col];
  }
};

/// Sums of a linear regression with an offset of its own.
struct Group {
  decltype(CellTerms::values) products = decltype(CellTerms::values)::Zero();
  Eigen::Matrix<double, CellTerms::kFirstProduct, 1> by_value = decltype(by_value)::Zero();
  double value_square = 0;

  void Add(const CellTerms& cell, double value) {
    products += cell.values;
    by_value += value * cell.values.head<CellTerms::kFirstProduct>();
    value_square += value * value;
  }
};

/// Least squares over groups of cells, the offsets eliminated.
struct Regression {
  Eigen::Matrix<double, kLightTerms, kLightTerms> normal = decltype(normal)::Zero();  ///< the lower triangle
  LightTerms right = LightTerms::Zero();
  double square = 0;  ///< of the values about their groups' means
  double freedom = 0;

  void Add(const Group& group, double times) {
    const double n = group.products[0], value = group.by_value[0];
    if (n < 4) return;
    const LightTerms sums = group.products.segment<kLightTerms>(1), means = sums / n;
    for (int row = 0, at = CellTerms::kFirstProduct; row < kLightTerms; ++row)
      for (int col = 0; col <= row; ++col) normal(row, col) += times * (group.products[at++] - means[row] * sums[col]);
    right += times * (group.by_value.tail<kLightTerms>() - value * means);
    square += times * (group.value_square - value * value / n);
    freedom += times * (n - 1);
  }
};

bool Shows(const ShadedCells& cells, std::size_t cell) {
  return cells.hidden.empty() || cells.hidden[cell] == Hidden::kNot;
}

/// Whether the level of a light cell tells the light in a phase.
bool TellsLight(const ShadedCells& cells, std::size_t cell, std::size_t phase) {
  const float level = cells.levels[cell][phase];
  const bool unseen = cells.saturated[cell] != 0 && static_cast<int>(phase) == cells.blue_phase;
  return !unseen && !(level - cells.veil[phase] < kLeastLevel) && !(level > kMostLevel);
}

/// Of the light cells' logarithms. @param terms(x, y) are a cell's, @param known(x, y) is taken off its logarithm.
template <class TermsAt, class Known>
Regression Regress(const ShadedCells& cells, const TermsAt& terms, const Known& known) {
  // The two phases of green have the same levels.
  const bool mosaic = cells.blue_phase >= 0;
  const int green = mosaic ? cells.blue_phase ^ 1 : -1, other_green = mosaic ? cells.blue_phase ^ 2 : -1;
  std::array<std::array<Group, 2>, 4> groups;  // by phase and saturation
  for (int row = 0; row < cells.size.rows; ++row)
    for (int col = IsDark(row, 0) ? 1 : 0; col < cells.size.cols; col += 2) {
      const std::size_t cell = static_cast<std::size_t>(row * cells.size.cols + col);
      if (!Shows(cells, cell)) continue;
      const Eigen::Vector2d at = MiddleOfCell(cells.size, static_cast<int>(cell));
      const CellTerms of_cell(terms(at.x(), at.y()));
      for (std::size_t phase = 0; phase < static_cast<std::size_t>(cells.phases); ++phase) {
        if (static_cast<int>(phase) == other_green || !TellsLight(cells, cell, phase)) continue;
        const double light = double{std::log(cells.levels[cell][phase] - cells.veil[phase])};
        groups[phase][cells.saturated[cell] != 0].Add(of_cell, light - known(at.x(), at.y()));
      }
    }
  Regression regression;
  for (int phase = 0; phase < cells.phases; ++phase)
    for (const Group& group : groups[static_cast<std::size_t>(phase)]) regression.Add(group, phase == green ? 2 : 1);
  return regression;
}

/// What a light cell sends in blue over what it sends in green, whatever light falls on it: of yellow, little.
float BlueShareOf(const ShadedCells& cells, std::size_t cell) {
  const std::size_t blue = static_cast<std::size_t>(cells.blue_phase), green = blue ^ 1;
  const PhaseValues& level = cells.levels[cell];
  return (level[blue] - cells.veil[blue]) / std::max(level[green] - cells.veil[green], kLeastLevel);
}

/// Which cells are saturated, with the light ones by their own colour: as they were told where those do not differ.
std::array<std::uint8_t, kMaxCells> InksByColour(const ShadedCells& cells) {
  std::array<std::uint8_t, kMaxCells> saturated{};
  std::copy(cells.saturated.begin(), cells.saturated.end(), saturated.begin());
  std::array<std::array<float, kMaxCells>, 2> shares;
  std::array<std::ptrdiff_t, 2> counts{};
  const auto for_light = [&](const auto& act) {
    ForCells(cells.size, [&](std::size_t cell, int row, int col) {
      if (!IsDark(row, col) && Shows(cells, cell)) act(cell, BlueShareOf(cells, cell));
    });
  };
  for_light([&](std::size_t cell, float share) {
    const std::size_t ink = cells.saturated[cell] != 0;
    shares[ink][static_cast<std::size_t>(counts[ink]++)] = share;
  });
  if (counts[0] == 0 || counts[1] == 0) return saturated;
  const auto median = [&](std::size_t ink) {
    const auto first = shares[ink].begin(), middle = first + counts[ink] / 2;
    std::nth_element(first, middle, first + counts[ink]);
    return *middle;
  };
  const float white = median(0), yellow = median(1);
  if (white - yellow < kLeastApart * white) return saturated;
  for_light([&](std::size_t cell, float share) { saturated[cell] = 2 * share < white + yellow; });
  return saturated;
}

double LightOf(const LightTerms& bent, double x, double y) { return 1 + bent.dot(Powers(x, y)); }

bool IsLight(const LightTerms& bent, MarkerSize size) {
  for (const double x : {-0.5, 0.0, 0.5})
    for (const double y : {-0.5, 0.0, 0.5})
      if (!(LightOf(bent, x * size.cols, y * size.rows) > kLeastLight)) return false;
  return true;
}

/// What counts of an estimate whose square, over `by_chance`, is so large, as James and Stein shrink it: nothing of a
/// weak one, nearly all of a strong one, and what lies between changes steadily, so that none decides by its noise.
double WhatCounts(double square, double by_chance) { return square > by_chance ? 1 - by_chance / square : 0; }

/// The second order of the light's logarithm as the cells tell it, and its information in the noise that they leave.
struct ToldBend {
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double by_chance = 0;  ///< its square in that may be by chance
};

/// None where the cells hardly tell one, or more than a weak shading's.
ToldBend BendOf(const Regression& regression) {
  if (regression.freedom < kFewestOfBend) return {};
  const SmallCholesky<kLightTerms> solver(regression.normal);
  if (!solver.positive()) return {};
  const LightTerms told = solver.Solve(regression.right);
  if (!told.allFinite() || told.head<2>().norm() > kMostPerCell || told.tail<3>().norm() > kMostBend) return {};
  const double left = regression.square - told.dot(regression.right), freedom = regression.freedom - kLightTerms,
               variance = std::max(left / freedom, Square(kSurestLevel));
  const Eigen::Matrix<double, kLightTerms, kLightTerms> normal = regression.normal.selfadjointView<Eigen::Lower>();
  const Eigen::Matrix3d information = normal.bottomRightCorner<3, 3>() - normal.bottomLeftCorner<3, 2>() *
                                                                             normal.topLeftCorner<2, 2>().inverse() *
                                                                             normal.topRightCorner<2, 3>();
  return {told.tail<3>(), information / variance, kBendByChance * (1 + kOverFreedom / freedom)};
}

/// A slope and a second order of the light's logarithm, by a regression on powers. @param slope_normal of the slope.
Shading FindWeak(const ShadedCells& cells, const Regression& regression, const Eigen::Matrix2d& slope_normal) {
  const Eigen::Matrix2d by_right = slope_normal.inverse();
  const auto slope_with = [&](const Eigen::Vector3d& bend) -> Eigen::Vector2d {
    return by_right * (regression.right.head<2>() - regression.normal.bottomLeftCorner<3, 2>().transpose() * bend);
  };
  const auto all_slope = [&](const Eigen::Vector2d& slope) -> Eigen::Vector2d {
    const Eigen::Vector2d all = cells.before.slope + slope;
    return cells.fine ? all : Eigen::Vector2d(WhatCounts(all.squaredNorm(), Square(kWeakSlope)) * all);
  };
  // Of all of it, whatever was taken out before: else what counts would depend on the order. What noise may make of the
  // second order is left out, so that light falls linearly; first levels do not tell it.
  const ToldBend told = BendOf(regression);
  const Eigen::Vector3d linear = Shading::BendOfLinear(all_slope(slope_with(told.bend))),
                        beside = cells.before.bend + told.bend - linear;
  const double square = cells.from == LevelsFrom::kFit ? beside.dot(told.information * beside) : 0,
               counts = cells.fine ? 1 : WhatCounts(square, told.by_chance);
  const Eigen::Vector3d bend = linear + counts * beside - cells.before.bend;
  return {all_slope(slope_with(bend)) - cells.before.slope, bend, false};
}

/// The third order of the logarithm of the polynomial that has those of a shading below it.
double ThirdOrderOf(const Shading& weak) {
  const double slope = weak.slope.norm();
  return slope * (slope * slope / 3 + (weak.bend - Shading::BendOfLinear(weak.slope)).norm());
}

/// What a shading of the light's logarithm leaves of the sum of squares.
double LeftBy(const Shading& shading, const Regression& regression) {
  LightTerms terms;
  terms << shading.slope, shading.bend;
  return regression.square - 2 * terms.dot(regression.right) +
         terms.dot(regression.normal.selfadjointView<Eigen::Lower>() * terms);
}

/// Gauss and Newton's descent from the slope. Nothing if it leaves more than `most_square`.
std::optional<Shading> FindBent(const ShadedCells& cells, const Eigen::Vector2d& slope, double most_square) {
  LightTerms bent;
  bent << slope, slope.x() * slope.x() / 2, slope.x() * slope.y(), slope.y() * slope.y() / 2;
  for (int step = 0; step <= kSteps; ++step) {
    if (!bent.allFinite() || !IsLight(bent, cells.size)) return std::nullopt;
    const Regression regression = Regress(
        cells, [&](double x, double y) -> LightTerms { return Powers(x, y) / LightOf(bent, x, y); },
        [&](double x, double y) { return std::log(LightOf(bent, x, y)); });
    if (step == kSteps) {
      if (regression.square > most_square || bent.head<2>().norm() > kMostPerCellBent) return std::nullopt;
      return Shading{bent.head<2>(), bent.tail<3>(), true};
    }
    const SmallCholesky<kLightTerms> solver(regression.normal);
    if (regression.freedom < 10 || !solver.positive()) return std::nullopt;
    bent += solver.Solve(regression.right);
  }
  return std::nullopt;
}

/// A linear regression of levels on how much the light there is above that at the centre.
struct LevelLine {
  double n = 0, x = 0, xx = 0, y = 0, xy = 0, yy = 0;

  void Add(double above, double level) {
    ++n, x += above, xx += above * above, y += level, xy += above * level, yy += level * level;
  }
  bool tells() const { return n >= kFewestDark && spread() > 0; }
  double spread() const { return xx - x * x / n; }
  double slope() const { return (xy - x * y / n) / spread(); }
  /// At the centre.
  double level() const { return (y - slope() * x) / n; }
  double left() const { return std::max(yy - y * y / n - slope() * slope() * spread(), 0.0); }
};

/// In one phase: the mean of the light cells at the centre, and the cells' lines by ink.
struct PhaseLevels {
  double light = 0;
  std::array<LevelLine, 2> dark, bright;
};

/// By phase.
std::array<PhaseLevels, 4> LevelsOf(const ShadedCells& cells, const Shading& shading) {
  std::array<PhaseLevels, 4> phases;
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (!Shows(cells, cell)) return;
    const std::size_t ink = cells.saturated[cell] != 0;
    const double share = shading.At(MiddleOfCell(cells.size, static_cast<int>(cell)));
    for (std::size_t phase = 0; phase < static_cast<std::size_t>(cells.phases); ++phase) {
      PhaseLevels& levels = phases[phase];
      const double level = cells.levels[cell][phase];
      if (IsDark(row, col)) {
        levels.dark[ink].Add(share - 1, level);
      } else if (TellsLight(cells, cell, phase)) {
        levels.bright[ink].Add(share - 1, level);
        levels.light += level / share;
      }
    }
  });
  for (PhaseLevels& levels : phases) levels.light /= std::max(levels.bright[0].n + levels.bright[1].n, 1.0);
  return phases;
}

/// By how much cells of one ink differ from their lines, as a share of the light cells: its square. Also of bright
/// ones, which lie on theirs where the shading is what falls on the board, and no shadow or lamp's image.
double VarianceOf(std::span<const PhaseLevels> phases) {
  double left = 0, freedom = 0;
  for (const PhaseLevels& levels : phases)
    for (const auto& lines : {levels.dark, levels.bright})
      for (const LevelLine& line : lines) {
        if (!line.tells()) continue;
        left += line.left() / Square(levels.light);
        freedom += line.n - 2;
      }
  return std::max(freedom > 0 ? left / freedom : 0, Square(kLeastOfLevel));
}

/// A value, and what is known of it.
struct Known {
  double value = 0, information = 0;

  void Add(const Known& other) {
    const double sum = information + other.information;
    if (sum > 0) value += (other.value - value) * other.information / sum;
    information = sum;
  }
};

/// The darkest ink's level, over the light cells: no veil is lighter.
double DarkestOf(const PhaseLevels& levels) {
  double darkest = 1;
  for (const LevelLine& line : levels.dark)
    if (line.tells()) darkest = std::min(darkest, line.level() / levels.light);
  return darkest;
}

/// What the dark cells of a phase tell of the veil, over its light cells: where these fall off from L by the share q of
/// it, dark ones from D by q b, it is L (D − b) / (L − b). @param variance as VarianceOf() has it.
Known VeilOf(const PhaseLevels& levels, double variance) {
  Known veil;
  for (const LevelLine& line : levels.dark) {
    if (!line.tells()) continue;
    const double dark = line.level() / levels.light,
                 slope = std::min(line.slope() / levels.light, dark + (1 - dark) / 2), below = 1 - slope,
                 by_slope = (1 - dark) / (below * below);
    veil.Add({(dark - slope) / below, line.spread() / (variance * by_slope * by_slope)});
  }
  return veil;
}

}  // namespace

std::optional<Shading> FindShading(const ShadedCells& told) {
  const auto regress = [](const ShadedCells& cells) {
    return Regress(cells, Powers, [](double, double) { return 0.0; });
  };
  ShadedCells cells = told;
  Regression regression = regress(cells);
  std::array<std::uint8_t, kMaxCells> inks;
  if (cells.blue_phase >= 0 && regression.square > kMisread * kMisread * regression.freedom) {
    inks = InksByColour(cells);
    cells.saturated = std::span(inks).first(cells.saturated.size());
    if (!std::ranges::equal(cells.saturated, told.saturated)) regression = regress(cells);
  }
  const Eigen::Matrix2d slope_normal = regression.normal.topLeftCorner<2, 2>().selfadjointView<Eigen::Lower>();
  if (!(slope_normal.determinant() > 1)) return std::nullopt;
  const Shading weak = FindWeak(cells, regression, slope_normal);
  if (!weak.slope.allFinite() || !weak.bend.allFinite()) return std::nullopt;
  const double slope = weak.slope.norm(), left = LeftBy(weak, regression);
  if (slope > kSteep && Square(kLeftOfThird * ThirdOrderOf(weak)) * regression.freedom > left)
    if (const auto bent = FindBent(cells, weak.slope, kBentLeaves * left)) return bent;
  if (slope > kMostPerCell) return std::nullopt;
  return weak;
}

PhaseValues FindVeil(const ShadedCells& cells, const Shading& shading) {
  const std::array<PhaseLevels, 4> levels = LevelsOf(cells, shading);
  const std::span<const PhaseLevels> phases = std::span(levels).first(static_cast<std::size_t>(cells.phases));
  for (const PhaseLevels& of_phase : phases)
    if (!(of_phase.light > 0)) return {};
  const double variance = VarianceOf(phases);
  if (variance > Square(kMostOfLevel)) return {};
  std::array<Known, 4> told;
  Known all{0, 1 / Square(kUsualVeil)};
  double darkest = kMostVeil;
  for (std::size_t phase = 0; phase < phases.size(); ++phase) {
    told[phase] = VeilOf(phases[phase], variance);
    all.Add(told[phase]);
    darkest = std::min(darkest, DarkestOf(phases[phase]));
  }
  const double uncertain = kCertainVeil / std::sqrt(all.information);
  if (!(all.value > -kMostVeil && all.value < kAboveDarkest * darkest + uncertain)) return {};
  all.value = std::min(all.value, darkest);
  all.value *= std::max(1 - Square(uncertain / all.value), 0.0);
  if (all.value == 0) return {};
  PhaseValues veil{};
  for (std::size_t phase = 0; phase < 4; ++phase) {
    const std::size_t same = phase % phases.size();
    Known of_phase{all.value, 1 / (Square(kVeilTint * all.value) + Square(kLeastTint))};
    of_phase.Add(told[same]);
    veil[phase] = static_cast<float>(of_phase.value * phases[same].light);
  }
  return veil;
}

void Shade(std::span<PhaseValues> levels, std::span<const float> shares, const PhaseValues& veil) {
  for (std::size_t cell = 0; cell < shares.size(); ++cell)
    for (std::size_t phase = 0; phase < 4; ++phase)
      levels[cell][phase] = veil[phase] + shares[cell] * (levels[cell][phase] - veil[phase]);
}

}  // namespace chequer
