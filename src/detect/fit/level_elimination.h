#pragma once

#include <array>
#include <vector>

#include "detect/fit/model_kernel.h"

namespace chequer {

/// The levels' part of a board's normal equations: for each channel a banded positive definite matrix, and the products
/// of its unknowns with the shared unknowns and, last, with the residual. The entries of all channels stand side by side,
/// so that one vector works on all of them. Keeps its memory; Begin() resets what it holds.
class LevelElimination {
 public:
  static constexpr int kSide = 4;  ///< entries side by side: one for each phase of the mosaic, later for each channel
  static constexpr int kNoLevel = -1;
  /// By place of the 4 × 4 cells around a corner: the level it has, or kNoLevel where its light is given.
  using LevelsAround = std::array<int, ModelColumns::kLevels>;

  /// @param width of the band below the diagonal.
  void Begin(int levels, int width, int shared);
  /// Adds the products of a corner's four lanes.
  void AddCorner(const ModelLanes& lanes, const ModelColumns& columns, int lane, const LevelsAround& levels);
  /// Adds up phases of the same channel, adds `ridge` of a channel's mean information to each of its levels, and
  /// factorises: L D Lᵀ. False if a matrix is not positive definite.
  bool Eliminate(const std::array<int, kSide>& channel_of_phase, double ridge);

  /// By which the product of the shared unknowns a ≤ b (or of a and the residual, b = shared) falls as the levels follow.
  double Taken(int a, int b) const;
  /// Finds the levels' step by that of the shared unknowns, with back substitution.
  void Solve(const double* shared_step);
  double step(int level, int channel) const { return step_[static_cast<std::size_t>(level * kSide + channel)]; }

  /// Where the entries stand: [(level (width + 1) + below) kSide + channel], [(level (shared + 1) + column) kSide +
  /// channel].
  struct Matrices {
    int levels = 0, width = 0, shared = 0;
    double* band = nullptr;
    double* common = nullptr;

    double* Band(int level, int below) const { return band + (level * (width + 1) + below) * kSide; }
    double* Common(int level, int column) const { return common + (level * (shared + 1) + column) * kSide; }
  };

 private:
  /// Entries after the last of `common`, which are read by those who take several columns at once.
  static constexpr int kBeyond = 3;

  Matrices at_;
  std::vector<double> band_, common_, taken_, by_diagonal_, step_;
};

}  // namespace chequer
