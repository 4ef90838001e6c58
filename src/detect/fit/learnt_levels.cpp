#include "detect/fit/learnt_levels.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/small_cholesky.h"

namespace chequer {
namespace {

/// Share of a frame in the mean of steps (a guess): of a board's 36 levels in one channel, the steps then are known to
/// a twentieth of what one frame tells of the levels.
constexpr double kShareOfFrame = 1.0 / 16;
/// Standard deviations beyond which a frame contradicts what was learnt (a guess: noise does so once in 10,000).
constexpr double kPlausible = 4;
/// Squares over what is expected, beyond which they tell nothing more of steps: so much of a lasting change is taken
/// for steps that a second of it is plausible (a guess).
constexpr double kMostSquare = 4;

}  // namespace

void WalkingValue::Age(int frames_on, double step_at_least) {
  const double moved = frames_on * std::max({step, step_at_least, 0.0});
  frames += frames_on;
  aged_by += moved;
  variance += moved;
}

void WalkingValue::LearnStep(double excess, double most) {
  const double seen = (aged_by + std::min(excess, most)) / frames;
  step += kShareOfFrame * (seen - step);
  frames = 0;
  aged_by = 0;
}

double LevelProducts::LightInformation() const {
  double sum = 0;
  for (int channel = 0; channel < channels; ++channel) sum += products(light(channel), light(channel));
  return sum;
}

WalkingValue StartLearning(const LevelProducts& products, const OwnEstimate& own) {
  // As long as nothing is known of steps, what one frame tells is worth half a frame.
  const double variance = own.pixel_variance / products.LightInformation();
  return {.variance = variance, .step = variance};
}

bool UseLearnt(const LevelProducts& products, const OwnEstimate& own, WalkingValue& light, LearntStep& step) {
  using Matrix = LevelProducts::Matrix;
  using SharedSquare = LevelProducts::SharedSquare;
  constexpr int kShared = LevelProducts::kShared;
  const int lights = products.lights();
  const Matrix by_levels = products.products.topRightCorner(kShared, 1 + lights);
  const SmallCholesky<kShared> factor(products.products.topLeftCorner<kShared, kShared>());
  const Matrix follow = factor.SolveEach(by_levels);
  // What the pixels tell of the levels, whatever the shared unknowns are; then of the difference beyond illumination.
  const Matrix known =
      products.products.bottomRightCorner(1 + lights, 1 + lights) - by_levels.transpose().lazyProduct(follow);
  const Eigen::LDLT<Matrix> of_lights(known.bottomRightCorner(lights, lights));
  step.lights = of_lights.solve(known.col(0).tail(lights));
  const double square = (known(0, 0) - step.lights.dot(known.col(0).tail(lights))) / own.pixel_variance,
               freedom = own.levels - lights, own_variance = own.pixel_variance / products.LightInformation(),
               expected = own_variance + light.variance, ratio = square / freedom * own_variance / expected;
  const bool plausible = ratio < 1 + kPlausible * std::sqrt(2 / freedom);
  light.LearnStep((ratio - 1) * expected, kMostSquare * expected);
  step.share = plausible ? own_variance / expected : 0;
  light.variance = plausible ? step.share * light.variance : own_variance;
  if (!plausible) return false;
  const Matrix by_light = follow.rightCols(lights);
  step.moves = step.share * (follow.col(0) - by_light * step.lights);
  // Where the levels are known but for their illumination.
  const SharedSquare with_levels =
      factor.Inverse() + by_light.lazyProduct(of_lights.solve(by_light.transpose()).eval());
  step.covariance = (1 - step.share) * own.covariance + step.share * with_levels;
  return true;
}

}  // namespace chequer
