#include "detect/fit/model_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Of the mean information about a level: what is added to each, so that a level that no pixel shows stays as it is.
constexpr double kRidge = 1e-6;
/// Steps that differ by a smaller share are the same, but for rounding.
constexpr double kSame = 1e-9;

}  // namespace

void ModelEquations::Assemble(const Input& input) {
  const ModelColumns& columns = input.columns;
  const int shared = columns.shared;
  levels_.Begin(input.level_count, std::min(input.band, input.level_count - 1), shared);
  std::array<const float*, kMaxCorners> sums_of;
  std::size_t corners = 0;
  for (int corner = 0; corner < input.pixels->corners(); ++corner) {
    const std::size_t i = static_cast<std::size_t>(corner);
    if (input.hidden[i] != Hidden::kNot) continue;
    const int lane = input.pixels->Lane(corner);
    levels_.AddCorner(*input.lanes, columns, lane, input.levels[i]);
    sums_of[corners++] = input.lanes->sum_data(0, lane);
  }
  const auto of_all = [&](int a, int b) {
    const std::ptrdiff_t at = ModelLanes::kNextProduct * std::ptrdiff_t{columns.Product(a, b)};
    Eigen::Array4d of_phases = Eigen::Array4d::Zero();
    for (std::size_t i = 0; i < corners; ++i)
      of_phases += Eigen::Map<const Eigen::Array4f>(sums_of[i] + at).cast<double>();
    return of_phases.sum();
  };
  normal_.setZero(shared, shared);
  gradient_.setZero(shared);
  for (int a = 0; a < shared; ++a) {
    for (int b = a; b < shared; ++b) normal_(b, a) = of_all(a, b);
    gradient_[a] = of_all(a, columns.residual());
  }
  chi_square_ = of_all(columns.residual(), columns.residual());
  if (input.prior_information.size() != shared) return;
  normal_.diagonal() += input.prior_information;
  gradient_ += input.prior_pull;
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

bool ModelEquations::SolveShared() {
  SharedMatrix normal = normal_;
  Shared gradient = gradient_;
  for (Eigen::Index i = 0; i < normal.rows(); ++i) {
    if (!made_[i]) continue;
    gradient -= step_[i] * normal_.col(i);
    normal.col(i).setZero(), normal.row(i).setZero();
    normal(i, i) = 1;
  }
  for (Eigen::Index i = 0; i < normal.rows(); ++i)
    if (made_[i]) gradient[i] = step_[i];
  // Of unknowns in very different units.
  const Shared scale = normal.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  normal = scale.asDiagonal() * normal * scale.asDiagonal();
  const Eigen::LDLT<SharedMatrix> factor(normal);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return false;
  step_ = scale.cwiseProduct(factor.solve(scale.cwiseProduct(gradient)));
  return step_.allFinite();
}

bool ModelEquations::Solve(const Input& input) {
  Assemble(input);
  const double before = chi_square_;
  if (!EliminateLevels(input)) return false;
  normal_.triangularView<Eigen::StrictlyUpper>() = normal_.transpose();
  made_.setConstant(normal_.rows(), false);
  if (!SolveShared()) return false;
  chi_square_ -= step_.dot(gradient_);
  fall_ = 1 - chi_square_ / std::max(before, 1e-9);
  levels_.Solve(step_.data());
  return true;
}

bool ModelEquations::Follow(const Shared& made) {
  bool any = false;
  for (Eigen::Index i = 0; i < step_.size(); ++i) {
    if (std::abs(made[i] - step_[i]) <= kSame * std::abs(step_[i])) continue;
    made_[i] = any = true;
    step_[i] = made[i];
  }
  if (!any) return false;
  const Shared last = step_;
  if (!SolveShared()) step_ = last;
  levels_.Solve(step_.data());
  return true;
}

ModelEquations::SharedMatrix ModelEquations::Covariance() const {
  return normal_.ldlt().solve(SharedMatrix::Identity(normal_.rows(), normal_.rows()));
}

BoardGeometry::Information ModelEquations::InformationOnMoves() const {
  constexpr int kMoves = BoardGeometry::kParameters;
  const Eigen::Index others = normal_.rows() - kMoves;
  const SharedMatrix common = normal_.bottomLeftCorner(others, kMoves);
  const Eigen::LDLT<SharedMatrix> factor(normal_.bottomRightCorner(others, others));
  return normal_.topLeftCorner<kMoves, kMoves>() - common.transpose() * factor.solve(common);
}

ModelEquations::CornerShift ModelEquations::ShiftOf(const Input& input, int corner) const {
  const ModelColumns& columns = input.columns;
  const int lane = input.pixels->Lane(corner);
  const LevelsAround16& levels = input.levels[static_cast<std::size_t>(corner)];
  constexpr std::array<int, 2> kShift{0, 3};  // of the geometry's columns, those of the coordinates themselves
  const float* const of_lane = input.lanes->sum_data(0, lane);
  const auto at = [&](int row, int along) -> Eigen::Array4d {
    return Eigen::Map<const Eigen::Array4f>(of_lane + ModelLanes::kNextProduct * (row + along)).cast<double>();
  };
  // The levels' steps, by place and phase.
  std::array<Eigen::Array4d, ModelColumns::kLevels> level_steps;
  for (std::size_t i = 0; i < level_steps.size(); ++i)
    for (std::size_t phase = 0; phase < 4; ++phase)
      level_steps[i][static_cast<Eigen::Index>(phase)] =
          levels[i] == kNoLevel ? 0 : LevelStep(levels[i], input.channel_of_phase[phase]);
  CornerShift shift;
  for (int axis = 0; axis < 2; ++axis) {
    const int column = kShift[static_cast<std::size_t>(axis)], row = columns.Row(column);
    const auto sums = [&](int other) {
      return other < column ? at(columns.Row(other), ModelColumns::Along(column)) : at(row, ModelColumns::Along(other));
    };
    for (int other = 0; other < 2; ++other)
      shift.information(axis, other) = sums(kShift[static_cast<std::size_t>(other)]).sum();
    Eigen::Array4d left = sums(columns.residual());
    for (int a = 0; a < columns.shared; ++a) left -= sums(a) * step_[a];
    for (int i = 0; i < ModelColumns::kLevels; ++i)
      left -= sums(columns.levels + i) * level_steps[static_cast<std::size_t>(i)];
    shift.gradient[axis] = left.sum();
  }
  return shift;
}

}  // namespace chequer
