#include "detect/fit/blur_shape.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

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

WayInBlur BlurShapeFit::InMiddle() const {
  const Blurred<double> at = BlurredAt(WayByTurn<double>{0, 0});
  const double x = std::sqrt(at.x), y = std::sqrt(at.y);
  // By a pixel from the other edge, along this one.
  const Eigen::Matrix2d by_turn = turned_ * across_.inverse();
  const double way_x_by_y = shape_.turn * by_turn(0, 1), way_y_by_x = shape_.turn * by_turn(1, 0);
  return {.share_x = kOfWay * at.way_x * at.way_x / at.x,
          .share_y = kOfWay * at.way_y * at.way_y / at.y,
          .skew = kOfWay * at.way_x * at.way_y / (x * y),
          .narrower_x = -kOfWay * at.way_x * way_x_by_y * y / at.x,
          .narrower_y = -kOfWay * at.way_y * way_y_by_x * x / at.y};
}

double BlurShapeFit::Step(double least_gain, BlurShape& shape) const {
  shape = shape_;
  if (shape_.round()) return StepOfRound(least_gain, shape);
  const Eigen::Matrix3d of_pixels = information_.selfadjointView<Eigen::Lower>();
  Eigen::Matrix3d information = of_pixels;
  Eigen::Vector3d gradient = gradient_;
  information(2, 2) += 1 / (kTurn * kTurn);
  gradient[2] -= shape_.turn / (kTurn * kTurn);
  if (!(information.determinant() > 0)) return 0;
  Eigen::Vector3d step = information.inverse() * gradient;
  const double length = step.head<2>().norm();
  if (length > kMostStepPx) step.head<2>() *= kMostStepPx / length;
  step[2] = std::clamp(step[2], -kMostTurnStep, kMostTurnStep);
  const double falls = step.dot(2 * gradient_ - of_pixels * step);
  shape.way_px += across_.inverse() * step.head<2>();
  shape.turn += step[2];
  return falls;
}

double BlurShapeFit::StepOfRound(double least_gain, BlurShape& shape) const {
  const auto gain = [](double residual, double square) { return square > 0 ? residual * residual / square : 0; };
  const double falls =
      gain(round_.uneven_residual, round_.uneven_square) + gain(round_.skew_residual, round_.skew_square);
  // With a turn of square t, Σ w r² and the prior change by t² round_.turn_square − 2 t round_.turn_residual + t /
  // kTurn².
  const double turn_residual = std::max(round_.turn_residual - 0.5 / (kTurn * kTurn), 0.0),
               turn_falls = gain(turn_residual, round_.turn_square);
  if (turn_falls > falls && turn_falls >= least_gain) {
    shape.turn = std::min(std::sqrt(turn_residual / round_.turn_square), kMostTurnStep);
    return turn_falls;
  }
  if (!(falls >= least_gain) || !(round_.uneven_square > 0) || !(round_.skew_square > 0)) return 0;
  // A way has its variance along it, and nothing across: each differs from their mean by half of it.
  const double difference = 2 * variance_ * round_.uneven_residual / round_.uneven_square,
               mixed = variance_ * round_.skew_residual / round_.skew_square;
  const double half = std::min(std::hypot(difference, mixed), (1 - kLeastOfLens) * variance_),
               angle = std::atan2(mixed, difference) / 2, length = std::sqrt(2 / kOfWay * half);
  shape.way_px = across_.inverse() * (length * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  return falls;
}

}  // namespace chequer
