#include "detect/model_equations.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/level_elimination.h"

namespace chequer {
namespace {

/// Of the mean information about a level: what is added to each, so that a level that no pixel shows stays as it is.
constexpr double kRidge = 1e-6;

}  // namespace

void ModelEquations::Assemble(const Input& input) {
  const int shared = input.columns.shared;
  band_width_ = std::min(input.band, input.level_count - 1);
  band_stride_ = PaddedForElimination(band_width_ + 1);
  right_ = PaddedForElimination(shared + 1);
  normal_.setZero(shared, shared);
  gradient_.setZero(shared);
  chi_square_ = 0;
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    const auto used = std::any_of(input.channel_of_phase.begin(), input.channel_of_phase.end(),
                                  [&](int of) { return of == static_cast<int>(channel); });
    const std::size_t levels = used ? static_cast<std::size_t>(input.level_count) : 0;
    band_[channel].assign(levels * static_cast<std::size_t>(band_stride_), 0);
    common_[channel].assign(levels * static_cast<std::size_t>(right_), 0);
    level_step_[channel].assign(levels, 0);
  }
  for (int corner = 0; corner < input.pixels->corners(); ++corner)
    if (input.used[static_cast<std::size_t>(corner)]) AddCorner(input, corner);
  if (input.prior_information.size() != shared) return;
  normal_.diagonal() += input.prior_information;
  gradient_ += input.prior_pull;
}

void ModelEquations::AddCorner(const Input& input, int corner) {
  const ModelColumns& columns = input.columns;
  const int lane = input.pixels->Lane(corner), shared = columns.shared, residual = columns.residual();
  const LevelsAround16& levels = input.levels[static_cast<std::size_t>(corner)];
  const auto sums = [&](int a, int b) { return input.lanes->sum_data(columns.Product(a, b)) + lane; };
  const auto all = [&](int a, int b) {
    const float* of = sums(a, b);
    return double{of[0]} + double{of[1]} + double{of[2]} + double{of[3]};
  };
  for (int a = 0; a < shared; ++a) {
    for (int b = a; b < shared; ++b) normal_(b, a) += all(a, b);
    gradient_[a] += all(a, residual);
  }
  chi_square_ += all(residual, residual);
  for (int i = 0; i < ModelColumns::kLevels; ++i) {
    const int level = levels[static_cast<std::size_t>(i)];
    if (level == kNoLevel) continue;
    const auto add_common = [&](const float* of, int column) {
      for (std::size_t phase = 0; phase < 4; ++phase)
        common_[static_cast<std::size_t>(input.channel_of_phase[phase])]
               [static_cast<std::size_t>(level * right_ + column)] += double{of[phase]};
    };
    for (int a = 0; a < shared; ++a) add_common(sums(a, columns.levels + i), a);
    add_common(sums(columns.levels + i, residual), shared);
    for (int j = i; j < ModelColumns::kLevels; ++j) {
      const int other = levels[static_cast<std::size_t>(j)];
      if (other == kNoLevel) continue;
      const float* of = sums(columns.levels + i, columns.levels + j);
      // Places that share a level count with each other, both ways.
      const double times = level == other && i != j ? 2 : 1;
      for (std::size_t phase = 0; phase < 4; ++phase)
        Band(static_cast<std::size_t>(input.channel_of_phase[phase]), std::min(level, other),
             std::abs(other - level)) += times * double{of[phase]};
    }
  }
}

bool ModelEquations::EliminateLevels(const Input& input, std::size_t channel) {
  const int levels = static_cast<int>(level_step_[channel].size());
  if (levels == 0) return true;
  double mean = 0;
  for (int level = 0; level < levels; ++level) mean += Band(channel, level, 0) / levels;
  if (!(mean > 0)) return false;
  std::vector<double>& common = common_[channel];
  for (int level = 0; level < levels; ++level) Band(channel, level, 0) += kRidge * mean;
  if (!chequer::EliminateLevels({.levels = levels,
                                 .width = band_width_,
                                 .band_stride = band_stride_,
                                 .common_stride = right_,
                                 .band = band_[channel].data(),
                                 .common = common.data()}))
    return false;
  const int shared = input.columns.shared;
  for (int level = 0; level < levels; ++level) {
    const double* const row = common.data() + level * right_;
    const double inverse = 1 / Band(channel, level, 0);
    for (int a = 0; a < shared; ++a) {
      const double scaled = row[a] * inverse;
      for (int b = a; b < shared; ++b) normal_(b, a) -= scaled * row[b];
      gradient_[a] -= scaled * row[shared];
    }
    chi_square_ -= row[shared] * row[shared] * inverse;
  }
  return true;
}

bool ModelEquations::Solve(const Input& input) {
  Assemble(input);
  for (std::size_t channel = 0; channel < kChannels; ++channel)
    if (!EliminateLevels(input, channel)) return false;
  const int shared = input.columns.shared;
  normal_.triangularView<Eigen::StrictlyUpper>() = normal_.transpose();
  // Of unknowns in very different units.
  const Shared scale = normal_.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  const SharedMatrix scaled = scale.asDiagonal() * normal_ * scale.asDiagonal();
  const Eigen::LDLT<SharedMatrix> factor(scaled);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return false;
  step_ = scale.cwiseProduct(factor.solve(scale.cwiseProduct(gradient_)));
  if (!step_.allFinite()) return false;
  chi_square_ -= step_.dot(gradient_);
  // The levels follow, by back substitution.
  for (std::size_t channel = 0; channel < kChannels; ++channel) {
    const int levels = static_cast<int>(level_step_[channel].size());
    for (int level = levels - 1; level >= 0; --level) {
      const double* const row = common_[channel].data() + level * right_;
      double value = row[shared];
      for (int a = 0; a < shared; ++a) value -= row[a] * step_[a];
      value /= Band(channel, level, 0);
      for (int below = 1; below <= band_width_ && level + below < levels; ++below)
        value -= Band(channel, level, below) * level_step_[channel][static_cast<std::size_t>(level + below)];
      level_step_[channel][static_cast<std::size_t>(level)] = value;
    }
  }
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
  const auto sums = [&](int a, int b) {
    return input.lanes->sum_data(columns.Product(std::min(a, b), std::max(a, b))) + lane;
  };
  const auto all = [&](int a, int b) {
    const float* of = sums(a, b);
    return double{of[0]} + double{of[1]} + double{of[2]} + double{of[3]};
  };
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
