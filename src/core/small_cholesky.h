#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace chequer {

/// The Cholesky factor L D Lᵀ of a small positive definite matrix: loops of known lengths, a third of the cost of
/// Eigen's, which are made for larger ones and take two seconds to compile for each size, and no roots, which all that
/// follows would wait for. All loops are unrolled: counting takes two thirds of the instructions of loops as short.
template <int kSize>
class SmallCholesky {
 public:
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using Vector = Eigen::Matrix<double, kSize, 1>;

  /// From the lower triangle.
  explicit SmallCholesky(const Matrix& matrix) {
    // Where L is not known yet stands L D.
#pragma GCC unroll 16
    for (int col = 0; col < kSize; ++col) {
      double pivot = matrix(col, col);
#pragma GCC unroll 16
      for (int k = 0; k < col; ++k) {
        const double scaled = factor_[col][k];
        factor_[col][k] = scaled * inverse_[k];
        pivot -= scaled * factor_[col][k];
      }
      positive_ &= pivot > 0;
      inverse_[col] = 1 / pivot;
#pragma GCC unroll 16
      for (int row = col + 1; row < kSize; ++row) {
        double value = matrix(row, col);
#pragma GCC unroll 16
        for (int k = 0; k < col; ++k) value -= factor_[row][k] * factor_[col][k];
        factor_[row][col] = value;
      }
    }
  }

  /// Whether the matrix is positive definite: nothing else is of use if not.
  bool positive() const { return positive_; }
  /// Whether no direction is that much less determined than another, by the pivots.
  bool IsSound(double least_share) const {
    double least = inverse_[0], most = inverse_[0];
    for (std::size_t k = 1; k < kCount; ++k) {
      least = inverse_[k] < least ? inverse_[k] : least;
      most = inverse_[k] > most ? inverse_[k] : most;
    }
    return positive_ && least > least_share * most;
  }

  Vector Solve(Vector x) const {
#pragma GCC unroll 16
    for (int row = 1; row < kSize; ++row)
#pragma GCC unroll 16
      for (int k = 0; k < row; ++k) x[row] -= factor_[row][k] * x[k];
#pragma GCC unroll 16
    for (int row = kSize - 1; row >= 0; --row) {
      x[row] *= inverse_[row];
#pragma GCC unroll 16
      for (int k = row + 1; k < kSize; ++k) x[row] -= factor_[k][row] * x[k];
    }
    return x;
  }

  /// The same for each column.
  template <class Derived>
  typename Derived::PlainObject SolveEach(const Eigen::MatrixBase<Derived>& right) const {
    typename Derived::PlainObject columns = right;
    for (Eigen::Index col = 0; col < columns.cols(); ++col) columns.col(col) = Solve(columns.col(col));
    return columns;
  }

  Matrix Inverse() const {
    Matrix inverse;
    for (int col = 0; col < kSize; ++col) inverse.col(col) = Solve(Vector::Unit(col));
    return inverse;
  }

 private:
  static constexpr std::size_t kCount = kSize;
  double factor_[kCount][kCount];  ///< L, below the diagonal
  double inverse_[kCount];         ///< of D
  bool positive_ = true;
};

/// Of a positive definite matrix.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> InverseOf(const Eigen::Matrix<double, kSize, kSize>& matrix) {
  return SmallCholesky<kSize>(matrix).Inverse();
}

}  // namespace chequer
