#include "detect/banded.h"

#include <algorithm>
#include <cmath>

namespace chequer {

void BandedSystem::Reset(int size, int band) {
  size_ = size;
  band_ = band;
  matrix_.assign(static_cast<std::size_t>(size * (band + 1)), 0.0);
  rhs_.assign(static_cast<std::size_t>(size * kColumns), 0.0);
}

void BandedSystem::Factor(double least) {
  for (int i = 0; i < size_; ++i) {
    double* row_i = &matrix_[static_cast<std::size_t>(i * (band_ + 1))];  // row_i[d] is (i, i − d)
    row_i[0] += least;
    for (int distance = std::min(band_, i); distance >= 0; --distance) {
      const int j = i - distance;
      const double* row_j = &matrix_[static_cast<std::size_t>(j * (band_ + 1))];
      double sum = row_i[distance];
      for (int k = std::max(0, i - band_); k < j; ++k) sum -= row_i[i - k] * row_j[j - k];
      row_i[distance] = distance == 0 ? std::sqrt(std::max(sum, least)) : sum / row_j[0];
    }
  }
}

void BandedSystem::SolveLower() {
  for (int i = 0; i < size_; ++i) {
    const double* row = &matrix_[static_cast<std::size_t>(i * (band_ + 1))];
    double* out = Rhs(i);
    const int reach = std::min(band_, i);
    for (int distance = 1; distance <= reach; ++distance) {
      const double factor = row[distance];
      const double* in = out - distance * kColumns;
      for (int c = 0; c < kColumns; ++c) out[c] -= factor * in[c];
    }
    const double inverse = 1 / row[0];
    for (int c = 0; c < kColumns; ++c) out[c] *= inverse;
  }
}

void BandedSystem::SolveUpper(int column) {
  for (int i = size_ - 1; i >= 0; --i) {
    double sum = Rhs(i)[column];
    for (int distance = 1; distance <= std::min(band_, size_ - 1 - i); ++distance)
      sum -= matrix_[static_cast<std::size_t>((i + distance) * (band_ + 1) + distance)] * Rhs(i + distance)[column];
    Rhs(i)[column] = sum / matrix_[static_cast<std::size_t>(i * (band_ + 1))];
  }
}

}  // namespace chequer
