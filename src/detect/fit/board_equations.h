#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "chequer/hidden.h"
#include "detect/common/board_geometry.h"
#include "detect/fit/board_pixels.h"

namespace chequer {

struct BoardSystem;
struct CornerTerms;

/// How much the board coordinates at a corner move by each parameter of the geometry, for a fixed pixel.
struct CornerDerivative {
  BoardGeometry::Parameters x = BoardGeometry::Parameters::Zero();
  BoardGeometry::Parameters y = BoardGeometry::Parameters::Zero();
};

/// Which levels the four quadrants around a corner have, in the order of the lanes' columns.
using QuadrantLevels = std::array<int, 4>;
/// Those of their cells, row by row of the board; or each its own, for boards whose cells are not lit alike all over.
inline QuadrantLevels LevelsAround(MarkerSize size, int corner, bool own_levels) {
  if (own_levels) return {4 * corner, 4 * corner + 1, 4 * corner + 2, 4 * corner + 3};
  return CellsAround(size, corner);
}
int LevelCount(MarkerSize size, bool own_levels);

/// Gauss-Newton's normal equations of one board, with the cells' levels, of which there are many but each touches only
/// its neighbours, eliminated (Schur complement over a banded Cholesky factor, which keeps six digits of what the
/// geometry's columns have: they should not be nearly alike). The four phases of the pixels are
/// solved side by side in vectors; those that share a channel hold the same sums and count once. Keeps its memory.
class BoardEquations {
 public:
  /// The geometry's parameters, then the blur.
  static constexpr int kUnknowns = BoardGeometry::kParameters + 1;
  using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;

  struct Input {
    const BoardPixels* pixels = nullptr;
    std::span<const Hidden> hidden;  ///< by corner: those that show are used
    /// The first so many have sums: corners without are left out.
    int lanes = KernelInput::kAllLanes;
    /// Phase of the red pixels of a mosaic; −1 if all phases are one channel.
    int red_phase = -1;
    /// The levels stay as they are: then the lanes need not have sums of them.
    bool fixed_levels = false;
    /// Of the quadrants, as LevelsAround() has them.
    bool own_levels = false;
  };

  /// By corner; they must outlive the calls of Assemble().
  void SetDerivatives(std::span<const CornerDerivative> derivatives);
  /// From the sums of the lanes.
  void Assemble(const Input& input);

  /// What is left for geometry and blur when the levels follow them: JᵀWJ, JᵀWr and Σ w r².
  const Matrix& normal() const { return normal_; }
  const Vector& gradient() const { return gradient_; }
  double chi_square() const { return chi_square_; }

  /// Moves the levels, cell by cell, as they follow a step of geometry and blur. @pre they were not fixed.
  void MoveLevels(const Vector& step, std::span<PhaseValues> levels);
  /// What a corner's pixels say of a shift of its own: its information, and the gradient.
  struct CornerShift {
    double xx = 0, xy = 0, yy = 0, x = 0, y = 0;
  };
  /// Of the corners that are used, by corner, beyond a step that the levels followed.
  void FindShifts(const Input& input, const Vector& step, std::span<CornerShift> shifts) const;

 private:
  void Prepare(MarkerSize size, bool own_levels);
  BoardSystem System() const;
  /// Of the corners that are used. Returns how many.
  int DescribeCorners(const Input& input, CornerTerms* terms) const;

  int cells_ = 0, band_ = 0, matrix_row_ = 0, lanes_ = 0;  ///< cells: levels
  PhaseValues phase_weight_{};                             ///< channels that phases share count once
  std::vector<float> floats_;
  std::span<const CornerDerivative> derivatives_;
  std::vector<float> repeated_;  ///< the derivatives, each as often as there are phases
  std::vector<float> merged_;    ///< the products of the lanes' columns, by channel
  /// Within floats_, by cell: entries of the matrix's column, from the diagonal down, and of the right-hand sides; four
  /// phases each. Single precision, as the sums that they are made of.
  float *matrix_ = nullptr, *right_ = nullptr;
  Matrix normal_ = Matrix::Zero();
  Vector gradient_ = Vector::Zero();
  double chi_square_ = 0;
};

}  // namespace chequer
