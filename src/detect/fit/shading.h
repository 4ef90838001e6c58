#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "chequer/hidden.h"
#include "detect/fit/board_equations.h"

namespace chequer {

/// How the light falls off over a board, over that at its centre.
struct Shading {
  /// Change per cell along x and y, at the centre.
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  /// Of x², xy and y².
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
  bool bent = false;

  /// At a point of the board: a polynomial of the light where it is bent (exact where the light falls linearly), else
  /// the exponential function of the same polynomial, which a weak gradient cannot be told from.
  double At(const Eigen::Vector2d& board) const {
    const double x = board.x(), y = board.y(),
                 fall = slope.x() * x + slope.y() * y + bend[0] * x * x + bend[1] * x * y + bend[2] * y * y;
    return bent ? 1 + fall : std::exp(fall);
  }
  /// The derivative of that polynomial there.
  Eigen::Vector2d SlopeAt(const Eigen::Vector2d& board) const {
    const double x = board.x(), y = board.y();
    return slope + Eigen::Vector2d(2 * bend[0] * x + bend[1] * y, bend[1] * x + 2 * bend[2] * y);
  }
  /// Of x², xy and y², at the centre.
  Eigen::Vector3d BendOfLogarithm() const { return bent ? Eigen::Vector3d(bend + BendOfLinear(slope)) : bend; }
  /// That of a light which falls linearly by a slope.
  static Eigen::Vector3d BendOfLinear(const Eigen::Vector2d& slope) {
    return {-slope.x() * slope.x() / 2, -slope.x() * slope.y(), -slope.y() * slope.y() / 2};
  }
};

/// Where cells' levels are from. Until a fit has settled they err alike, as if the light were bent.
enum class LevelsFrom { kFirstSteps, kFit };

/// What FindShading looks at, cell by cell, row by row.
struct ShadedCells {
  MarkerSize size;
  std::span<const PhaseValues> levels;
  std::span<const std::uint8_t> saturated;
  /// Only cells that show tell of the light; may be empty: all do.
  std::span<const Hidden> hidden;
  int phases = 1;       ///< that differ
  int blue_phase = -1;  ///< that hardly sees yellow, −1 for none
  bool fine = false;    ///< their levels are known so well that they tell a weak slope
  LevelsFrom from = LevelsFrom::kFit;
  /// Light that lies over the board and does not fall off with the other: haze, what glossy paper mirrors of a bright
  /// room, or a black level that the camera has not taken off. Levels are veil + share · (level − veil), with the share
  /// as Shading has it.
  PhaseValues veil{};
  /// What was taken out of the levels before, of the light's logarithm.
  Shading before{};
};

/// How the light over a board falls off beside what was taken out before, by least squares over the logarithms of the
/// light cells' levels, with an ink of its own for each phase and saturation. Of slope and second order, all in all,
/// the more counts the surer it is, so that noise does not decide: of a slope, how much steeper it is than what moves
/// no pose; of the second order, how far it is from that of light that falls linearly. Where an exponential function
/// leaves four times as much as a polynomial of the light itself, it is bent. Where light cells of one ink differ a
/// lot, the saturation of some was misread: it is then told anew, by the colours of the levels. Nothing where the cells
/// do not determine it or differ too much for the model. 9,000 instructions for 36 cells; six times as many where a
/// bent one is tried.
std::optional<Shading> FindShading(const ShadedCells& cells);

/// A veil, by the dark cells' levels: under one they do not fall off as the light cells' do. What they do not determine
/// well is less, none at all in the end. @pre the cells' own veil is none. @param shading of the light cells.
PhaseValues FindVeil(const ShadedCells& cells, const Shading& shading);

/// Shades the levels of each cell by its share of the light. Without shares, it changes nothing.
void Shade(std::span<PhaseValues> levels, std::span<const float> shares, const PhaseValues& veil);

}  // namespace chequer
