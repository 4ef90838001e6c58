#include "detect/edge_shape.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace chequer {
namespace {

/// As many pixels tell a shape.
constexpr int kPixels = 1500;
/// Steps of the differences, as large as shapes are: χ² is a parabola.
constexpr double kThirdStep = 0.02, kFifthStep = 0.01;

/// Σ cos⁴ and Σ cos⁶ over the image's axes.
Eigen::Vector2d TurnedBy(const Eigen::Vector2d& normal) {
  const Eigen::Array2d square = normal.normalized().array().square();
  return {square.square().sum(), square.cube().sum()};
}

/// Weighs a lane's pixels alike: weights that follow the model would make χ² no parabola.
void LevelNoise(int lane, LaneBlock& lanes) {
  const auto value = [&](LaneBlock::Parameter which) -> float& { return lanes.parameter_data(which)[lane]; };
  const float light =
      0.25f * (value(LaneBlock::kL00) + value(LaneBlock::kL10) + value(LaneBlock::kL01) + value(LaneBlock::kL11));
  value(LaneBlock::kNoiseFloor) += value(LaneBlock::kNoiseSlope) * std::max(light, 0.0f);
  value(LaneBlock::kNoiseSlope) = 0;
}

/// Σ over the used lanes.
struct Sums {
  double residual_square = 0, blur_residual = 0, blur_square = 0;
};

Sums SumsOf(std::span<const bool> used, const BoardPixels& pixels) {
  Sums sums;
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (!used[static_cast<std::size_t>(corner)]) continue;
    for (int lane = pixels.Lane(corner); lane < pixels.Lane(corner) + 4; ++lane) {
      const auto sum = [&](int a, int b) { return static_cast<double>(pixels.lanes().sum(ProductSum(a, b), lane)); };
      sums.residual_square += sum(kResidual, kResidual);
      sums.blur_residual += sum(kBlur, kResidual);
      sums.blur_square += sum(kBlur, kBlur);
    }
  }
  return sums;
}

}  // namespace

EdgeTerms TermsOf(const EdgeShape& shape, const Eigen::Vector2d& normal) {
  const Eigen::Vector2d turned = TurnedBy(normal);
  const double third = shape.third * turned.x(), fifth = shape.fifth * turned.y();
  return {static_cast<float>(15 * fifth - 3 * third), static_cast<float>(third - 10 * fifth),
          static_cast<float>(fifth)};
}

EdgeShapeStep FindEdgeShape(KernelInput input, const Eigen::Vector2d& normal_x, const Eigen::Vector2d& normal_y,
                            std::span<const bool> used, BoardPixels& pixels) {
  LaneBlock& lanes = pixels.lanes();
  int count = 0;
  for (int lane = 0; lane < lanes.lanes(); ++lane) {
    count += lanes.count(lane);
    LevelNoise(lane, lanes);
  }
  input.stride = std::max(1, count / kPixels);
  input.sums = LaneSums::kShapes;
  const auto evaluate = [&](double third, double fifth) {
    const EdgeShape shape{third, fifth};
    input.edge_x = TermsOf(shape, normal_x);
    input.edge_y = TermsOf(shape, normal_y);
    AccumulateLanes(input, lanes);
    return SumsOf(used, pixels);
  };
  const Sums plain = evaluate(0, 0), more_third = evaluate(kThirdStep, 0), less_third = evaluate(-kThirdStep, 0),
             more_fifth = evaluate(0, kFifthStep), less_fifth = evaluate(0, -kFifthStep),
             more_both = evaluate(kThirdStep, kFifthStep);
  // By blur, third and fifth: χ² = square − 2 right · step + step · normal step.
  const auto slope = [](const Sums& less, const Sums& more, double step) {
    return (less.residual_square - more.residual_square) / (4 * step);
  };
  const auto bend = [&](const Sums& less, const Sums& more, double step) {
    return (less.residual_square + more.residual_square - 2 * plain.residual_square) / (2 * step * step);
  };
  const double with_third = (less_third.blur_residual - more_third.blur_residual) / (2 * kThirdStep),
               with_fifth = (less_fifth.blur_residual - more_fifth.blur_residual) / (2 * kFifthStep),
               both = (more_both.residual_square - more_third.residual_square - more_fifth.residual_square +
                       plain.residual_square) /
                      (2 * kThirdStep * kFifthStep);
  const Eigen::Vector3d right(plain.blur_residual, slope(less_third, more_third, kThirdStep),
                              slope(less_fifth, more_fifth, kFifthStep));
  Eigen::Matrix3d normal;
  normal << plain.blur_square, with_third, with_fifth,             //
      with_third, bend(less_third, more_third, kThirdStep), both,  //
      with_fifth, both, bend(less_fifth, more_fifth, kFifthStep);
  const Eigen::LLT<Eigen::Matrix3d> solver(normal);
  if (solver.info() != Eigen::Success) return {};
  const Eigen::Vector3d step = solver.solve(right);
  if (!step.allFinite()) return {};
  return {.more = {step[1], step[2]}, .blur_px = step[0], .gain = input.stride * step.dot(right)};
}

}  // namespace chequer
