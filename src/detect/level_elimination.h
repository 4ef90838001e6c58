#pragma once

namespace chequer {

/// The levels' part of a board's normal equations, one channel: a banded positive definite matrix, and what its unknowns
/// have in common with others.
struct LevelSystem {
  int levels = 0;
  int width = 0;  ///< of the band below the diagonal
  int band_stride = 0, common_stride = 0;
  double* band = nullptr;    ///< by column, from the diagonal down; a column every band_stride
  double* common = nullptr;  ///< by level; a row every common_stride
};

/// Strides of rows that are worked on whole, for so many entries.
constexpr int PaddedForElimination(int entries) { return (entries + 7) / 8 * 8; }

/// Replaces the matrix by its factors L D Lᵀ (D on the diagonal) and `common` by L⁻¹ times it, all of each row. False
/// if the matrix is not positive definite.
bool EliminateLevels(const LevelSystem& system);

}  // namespace chequer
