#include "detect/fit/model_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Of the mean information about a level: what is added to each, so that a level that no pixel shows stays as it is.
constexpr double kRidge = 1e-6;

/// Of a corner's four lanes, one for each phase. @pre a ≤ b.
const float* SumsOf(const ModelEquations::Input& input, int lane, int a, int b) {
  return input.lanes->sum_data(input.columns.Product(a, b), lane);
}

double OfAllPhases(const float* of) { return double{of[0]} + double{of[1]} + double{of[2]} + double{of[3]}; }

}  // namespace

void ModelEquations::Assemble(const Input& input) {
  const int shared = input.columns.shared;
  normal_.setZero(shared, shared);
  gradient_.setZero(shared);
  chi_square_ = 0;
  levels_.Begin(input.level_count, std::min(input.band, input.level_count - 1), shared);
  for (int corner = 0; corner < input.pixels->corners(); ++corner)
    if (input.used[static_cast<std::size_t>(corner)]) AddCorner(input, corner);
  if (input.prior_information.size() != shared) return;
  normal_.diagonal() += input.prior_information;
  gradient_ += input.prior_pull;
}

void ModelEquations::AddCorner(const Input& input, int corner) {
  const ModelColumns& columns = input.columns;
  const int lane = input.pixels->Lane(corner), shared = columns.shared, residual = columns.residual();
  const auto all = [&](int a, int b) { return OfAllPhases(SumsOf(input, lane, a, b)); };
  for (int a = 0; a < shared; ++a) {
    for (int b = a; b < shared; ++b) normal_(b, a) += all(a, b);
    gradient_[a] += all(a, residual);
  }
  chi_square_ += all(residual, residual);
  levels_.AddCorner(*input.lanes, columns, lane, input.levels[static_cast<std::size_t>(corner)]);
}

bool ModelEquations::EliminateLevels(const Input& input) {
  if (!levels_.Eliminate(input.channel_of_phase, kRidge)) return false;
  const int shared = input.columns.shared;
  for (int a = 0; a < shared; ++a) {
    for (int b = a; b < shared; ++b) normal_(b, a) -= levels_.Taken(a, b);
    gradient_[a] -= levels_.Taken(a, shared);
  }
  chi_square_ -= levels_.Taken(shared, shared);
  return true;
}

bool ModelEquations::Solve(const Input& input) {
  Assemble(input);
  if (!EliminateLevels(input)) return false;
  normal_.triangularView<Eigen::StrictlyUpper>() = normal_.transpose();
  // Of unknowns in very different units.
  const Shared scale = normal_.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  const SharedMatrix scaled = scale.asDiagonal() * normal_ * scale.asDiagonal();
  const Eigen::LDLT<SharedMatrix> factor(scaled);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return false;
  step_ = scale.cwiseProduct(factor.solve(scale.cwiseProduct(gradient_)));
  if (!step_.allFinite()) return false;
  chi_square_ -= step_.dot(gradient_);
  levels_.Solve(step_.data());
  return true;
}

ModelEquations::SharedMatrix ModelEquations::Covariance() const {
  return normal_.ldlt().solve(SharedMatrix::Identity(normal_.rows(), normal_.rows()));
}

ModelEquations::CornerShift ModelEquations::ShiftOf(const Input& input, int corner) const {
  const ModelColumns& columns = input.columns;
  const int lane = input.pixels->Lane(corner);
  const LevelsAround16& levels = input.levels[static_cast<std::size_t>(corner)];
  constexpr std::array<int, 2> kShift{0, 3};  // of the geometry's columns, those of the coordinates themselves
  const auto sums = [&](int a, int b) { return SumsOf(input, lane, std::min(a, b), std::max(a, b)); };
  const auto all = [&](int a, int b) { return OfAllPhases(sums(a, b)); };
  CornerShift shift;
  for (int axis = 0; axis < 2; ++axis) {
    const int column = kShift[static_cast<std::size_t>(axis)];
    for (int other = 0; other < 2; ++other)
      shift.information(axis, other) = all(column, kShift[static_cast<std::size_t>(other)]);
    double left = all(column, columns.residual());
    for (int a = 0; a < columns.shared; ++a) left -= all(column, a) * step_[a];
    for (int i = 0; i < ModelColumns::kLevels; ++i) {
      const int level = levels[static_cast<std::size_t>(i)];
      if (level == kNoLevel) continue;
      const float* of = sums(column, columns.levels + i);
      for (std::size_t phase = 0; phase < 4; ++phase)
        left -= double{of[phase]} * LevelStep(level, input.channel_of_phase[phase]);
    }
    shift.gradient[axis] = left;
  }
  return shift;
}

}  // namespace chequer
