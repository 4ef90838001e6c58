#pragma once

#include <cstddef>

#include "detect/fit/photometric_kernel.h"

namespace chequer {

/// The normal equations of a board, as board_system.cpp works on them: plain arrays, so that nothing that other files
/// use too is compiled for one target.
struct BoardSystem {
  /// Eight parameters of the geometry, the blur, the residual.
  static constexpr int kColumns = 10;
  /// Floats of a cell's right-hand sides: whole vectors, whatever their length.
  static constexpr int kRightRow = 48;
  /// Floats that are read beyond a column's band, at most.
  static constexpr int kColumnTail = 32;

  bool fixed_levels = false;
  int cells = 0, band = 0;
  /// Floats of a column of the matrix: entries up to the band, then zeros, which vectors run into.
  int matrix_row = 0;
  // Both at whole vectors in memory.
  float* matrix = nullptr;  ///< [cell][entry from the diagonal down][4], rows of matrix_row
  float* right = nullptr;   ///< [cell][column][4], rows of kRightRow; follows the matrix
  float phase_weight[4] = {};
  double normal[kColumns][kColumns] = {};  ///< upper triangle
};

/// How the four phases share channels: merged[k] = half[k] + beside · half[k ^ 1], half[k] = sum[k] + opposite[k] ·
/// sum[3 − k].
struct PhaseShares {
  float opposite[4];
  float beside;
};

/// A corner as it is added.
struct CornerTerms {
  int corner, lane;                      ///< the first of its lanes
  int cell_of[4];                        ///< the four cells around it
  const double *by_x, *by_y;             ///< moves of its board coordinates by the geometry's parameters
  const float *repeated_x, *repeated_y;  ///< each of them four times
};

/// Sums of lanes, kinds of them as of the kernel's.
struct SumsOfLanes {
  const float* data;
  std::ptrdiff_t stride;  ///< from one kind of sum to the next: whole groups of lanes

  const float* Of(int a, int b, int lane) const { return data + ProductSum(a, b) * stride + lane; }
};

/// Adds up the corners' sums and eliminates the levels, unless they are fixed: fills BoardSystem::normal.
/// @param lanes the first so many have sums. @param least added to the diagonal of the levels. @param merged room for
/// what `sums` has: is left with those of channels.
void SolveBoard(const CornerTerms* corners, int count, const SumsOfLanes& sums, int lanes, const PhaseShares& shares,
                float least, float* merged, BoardSystem& system);
/// The levels' moves for a step of the unknowns, into the first right-hand side. @pre SolveBoard().
void SolveLevels(const float* unknowns, BoardSystem& system);
/// Fills BoardEquations::CornerShift of each corner. @param right of the levels' equations, where their moves are.
/// @param weight of phases.
void FindCornerShifts(const CornerTerms* corners, int count, const SumsOfLanes& merged, const float* right,
                      const float* weight, const double* step, double* shifts);

}  // namespace chequer
