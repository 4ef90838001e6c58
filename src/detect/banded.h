#pragma once

#include <cstddef>
#include <vector>

namespace chequer {

/// A symmetric positive definite system with a narrow band and several right-hand sides: the levels of a board's cells,
/// of which only neighbours touch. Keeps its memory.
class BandedSystem {
 public:
  /// Right-hand sides. Their number is fixed, so that loops over them unroll.
  static constexpr int kColumns = 10;

  /// All zero. @param band the farthest index distance of two unknowns that touch.
  void Reset(int size, int band);

  int size() const { return size_; }
  /// Entry of the lower triangle. @pre 0 ≤ row − col ≤ band.
  double& At(int row, int col) { return matrix_[static_cast<std::size_t>(row * (band_ + 1) + (row - col))]; }
  double* Rhs(int row) { return &rhs_[static_cast<std::size_t>(row * kColumns)]; }

  /// Cholesky factor A = L Lᵀ in place. `least` is added to the diagonal first, for unknowns that nothing has seen.
  void Factor(double least);
  /// Right-hand sides b become L⁻¹ b: products of two such columns are those of b with A⁻¹ between.
  void SolveLower();
  /// Then L⁻ᵀ of one column, in place; after SolveLower this makes that column A⁻¹ b.
  void SolveUpper(int column);

 private:
  int size_ = 0, band_ = 0;
  std::vector<double> matrix_, rhs_;
};

}  // namespace chequer
