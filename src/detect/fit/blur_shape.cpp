#include "detect/fit/blur_shape.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Variance of what is spread evenly over a way, over the way's square.
constexpr double kOfWay = 1.0 / 12;
/// What is left of a blur's variance without the way at least: of longer ones, it is none of a Gaussian (a guess).
constexpr double kLeastOfLens = 0.25;
/// Steps go no farther: px, rad.
constexpr double kMostStepPx = 1, kMostTurnStep = 0.03;
/// Robots turn by 5 rad/s, and shutters are open for 10 ms (a guess).
constexpr double kTurn = 0.05;

}  // namespace

BlurShapeFit::BlurShapeFit(const BlurShape& shape, const Eigen::Matrix2d& across, double blur_px)
    : shape_(shape), across_(across), way_(across * shape.way_px), variance_(blur_px * blur_px) {
  turned_ << across(0, 1), -across(0, 0), across(1, 1), -across(1, 0);
  SetMeanSquare(0);
}

void BlurShapeFit::SetMeanSquare(double square) {
  mean_square_ = square;
  const double way = way_.squaredNorm() + shape_.turn * shape_.turn * square;
  lens_ = std::max(variance_ - kOfWay / 2 * way, kLeastOfLens * variance_);
}

BlurShapeFit::Blurred BlurShapeFit::BlurredAt(const Eigen::Vector2d& by_turn) const {
  const Eigen::Vector2d way = way_ + shape_.turn * by_turn;
  return {way, lens_ + kOfWay * way.x() * way.x(), lens_ + kOfWay * way.y() * way.y()};
}

CornerBlur BlurShapeFit::At(const Eigen::Vector2d& by_turn) const {
  const auto [way, x, y] = BlurredAt(by_turn);
  return {std::sqrt(x / variance_), std::sqrt(y / variance_), kOfWay * way.x() * way.y() / std::sqrt(x * y)};
}

void BlurShapeFit::Add(const Eigen::Vector2d& by_turn, const CornerBlurSums& sums) {
  if (shape_.round()) {
    sums_.uneven_residual += sums.uneven_residual;
    sums_.uneven_square += sums.uneven_square;
    sums_.skew_residual += sums.skew_residual;
    sums_.skew_square += sums.skew_square;
    return;
  }
  const auto [way, x, y] = BlurredAt(by_turn);
  // The deviations' logarithms; what the way adds on the whole, the lens has less.
  const Eigen::Vector3d lens = kOfWay / 2 * Eigen::Vector3d(way_.x(), way_.y(), shape_.turn * mean_square_);
  const Eigen::Vector3d log_x = (kOfWay * way.x() * Eigen::Vector3d(1, 0, by_turn.x()) - lens) / x,
                        log_y = (kOfWay * way.y() * Eigen::Vector3d(0, 1, by_turn.y()) - lens) / y;
  const auto add = [&](const Eigen::Vector3d& by, double residual, double square) {
    gradient_ += residual * by;
    information_.noalias() += (square * by) * by.transpose();
  };
  add((log_x + log_y) / 2, sums.both_residual, sums.both_square);
  add((log_x - log_y) / 2, sums.uneven_residual, sums.uneven_square);
  const double turn = way.x() * by_turn.y() + way.y() * by_turn.x();
  const double mean = std::sqrt(x * y);
  add(kOfWay / mean * Eigen::Vector3d(way.y(), way.x(), turn), sums.skew_residual, sums.skew_square);
  const auto round_leaves = [](double value, double residual, double square) {
    return value * (2 * residual + value * square);
  };
  round_leaves_ += round_leaves(std::log(x / y) / 4, sums.uneven_residual, sums.uneven_square) +
                   round_leaves(kOfWay * way.x() * way.y() / mean, sums.skew_residual, sums.skew_square);
}

double BlurShapeFit::Step(double least_gain, BlurShape& shape) const {
  shape = shape_;
  if (shape_.round()) return StepOfRound(least_gain, shape);
  Eigen::Matrix3d information = information_;
  Eigen::Vector3d gradient = gradient_;
  information(2, 2) += 1 / (kTurn * kTurn);
  gradient[2] -= shape_.turn / (kTurn * kTurn);
  if (!(information.determinant() > 0)) return 0;
  Eigen::Vector3d step = information.inverse() * gradient;
  const double length = step.head<2>().norm();
  if (length > kMostStepPx) step.head<2>() *= kMostStepPx / length;
  step[2] = std::clamp(step[2], -kMostTurnStep, kMostTurnStep);
  const double falls = step.dot(2 * gradient_ - information_ * step);
  if (!(round_leaves_ + falls >= least_gain)) {
    shape = {};
    return std::abs(round_leaves_);
  }
  shape.way_px += across_.inverse() * step.head<2>();
  shape.turn += step[2];
  return falls;
}

double BlurShapeFit::StepOfRound(double least_gain, BlurShape& shape) const {
  const auto gain = [](double residual, double square) { return square > 0 ? residual * residual / square : 0; };
  const double falls = gain(sums_.uneven_residual, sums_.uneven_square) + gain(sums_.skew_residual, sums_.skew_square);
  if (!(falls >= least_gain) || !(sums_.uneven_square > 0) || !(sums_.skew_square > 0)) return 0;
  // A way has its variance along it, and nothing across: each differs from their mean by half of it.
  const double difference = 2 * variance_ * sums_.uneven_residual / sums_.uneven_square,
               mixed = variance_ * sums_.skew_residual / sums_.skew_square;
  const double half = std::min(std::hypot(difference, mixed), (1 - kLeastOfLens) * variance_),
               angle = std::atan2(mixed, difference) / 2, length = std::sqrt(2 / kOfWay * half);
  shape.way_px = across_.inverse() * (length * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  return falls;
}

}  // namespace chequer
