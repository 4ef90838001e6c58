#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <array>
#include <span>
#include <vector>

#include "chequer/hidden.h"
#include "detect/fit/board_equations.h"
#include "detect/fit/board_pixels.h"
#include "detect/fit/level_elimination.h"
#include "detect/fit/model_kernel.h"

namespace chequer {

/// Gauss-Newton's normal equations of a board's model with its terms: geometry, blur and terms are solved for together
/// with all levels of cells, which are eliminated first (Schur complement, level_elimination.h). Keeps its memory.
class ModelEquations {
 public:
  /// Geometry, blur and terms, in the order of ModelColumns.
  using Shared = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, ModelColumns::kMostShared, 1>;
  using SharedMatrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, ModelColumns::kMostShared, ModelColumns::kMostShared>;
  static constexpr int kNoLevel = LevelElimination::kNoLevel;
  using LevelsAround16 = LevelElimination::LevelsAround;

  struct Input {
    const BoardPixels* pixels = nullptr;
    const ModelLanes* lanes = nullptr;
    ModelColumns columns{{}};
    std::span<const Hidden> hidden;  ///< by corner: those that show are used
    /// By corner.
    std::span<const LevelsAround16> levels;
    std::array<int, 4> channel_of_phase{};
    int level_count = 0;
    /// How much farther apart than that no two levels of a corner are counted.
    int band = 0;
    /// What is known of the shared unknowns beside the pixels: information, and that times how far off they are.
    Shared prior_information, prior_pull;
  };
  /// Assembles and solves. False if the pixels do not determine all that is sought.
  bool Solve(const Input& input);

  const Shared& step() const { return step_; }
  /// Where some shared unknowns were not moved by step() but by what `made` has for them, all others follow: they are
  /// solved for anew with these as they are, and those of earlier calls since Solve(). False where none differs.
  bool Follow(const Shared& made);
  double LevelStep(int level, int channel) const { return levels_.step(level, channel); }
  /// Of the shared unknowns, the levels following them.
  const SharedMatrix& information() const { return normal_; }
  SharedMatrix Covariance() const;
  /// On the moves of the geometry, which come first, all else following.
  BoardGeometry::Information InformationOnMoves() const;
  /// On some of them, all else following.
  template <int kCount>
  Eigen::Matrix<double, kCount, kCount> InformationOn(int first) const {
    return Covariance().block<kCount, kCount>(first, first).inverse();
  }
  /// Σ w r² as it will be after the step, to first order.
  double chi_square() const { return chi_square_; }
  /// By what share that will have fallen.
  double fall() const { return fall_; }

  /// What a corner's pixels say of a shift of its own, beyond the step: its information, and where it lies.
  struct CornerShift {
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  };
  CornerShift ShiftOf(const Input& input, int corner) const;

 private:
  void Assemble(const Input& input);
  bool EliminateLevels(const Input& input);
  bool SolveShared();

  SharedMatrix normal_;
  Shared gradient_, step_;
  Eigen::Array<bool, Eigen::Dynamic, 1, 0, ModelColumns::kMostShared, 1> made_;  ///< by unknown: its step is given
  double chi_square_ = 0, fall_ = 0;
  LevelElimination levels_;
};

}  // namespace chequer
