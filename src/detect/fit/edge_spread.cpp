#include "detect/fit/edge_spread.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/small_cholesky.h"
#include "detect/common/normal_integral.h"
#include "detect/fit/parabola.h"

namespace chequer {
namespace {

/// As many pixels tell a shape.
constexpr int kPixels = 1500;
/// Of a pixel along an axis.
constexpr double kPixelVariance = 1.0 / 12;
/// The lens's own blur at the least, and the variance that is left for it and the filter: a profile without it has
/// kinks, one of nothing no width.
constexpr double kSharpest = 0.03, kLeastVariance = 0.02;
/// An edge along the pixels is taken for one so much off: the pixel then has a width both ways.
constexpr double kLeastAcross = 0.02;
/// Edges so little more upright than others (radians) have their profile.
constexpr double kAlikeSlant = 0.02;
/// Of corners' terms, where all blur is smoothing by a sixth or more: found by integrating over both axes. The lens's
/// variance, square pixels, lessens them by e to this.
constexpr double kCornerSquare = -0.155, kCornerProduct = 0.36, kFullFilter = 0.15, kLensLessens = 8.2;
/// Filters that are tried beside none: that far to either side, and twice as far.
constexpr double kFilterStep = 0.5;
/// Filters so near to each other are one.
constexpr double kNearFilter = 0.03;
/// An image's edges are no Gaussian's where another shape explains so much more of χ² (noise alone: 2).
constexpr double kLeastGain = 25;

/// Twice the integral of the normal distribution: a ramp with a round foot.
class Ramp {
 public:
  Ramp() {
    for (int i = 0; i < kEntries; ++i) {
      const double z = i * kStep - kEnd;
      value_[static_cast<std::size_t>(i)] = 0.5 * ((z * z + 1) * NormalIntegral(z) + z * NormalDensity(z));
      slope_[static_cast<std::size_t>(i)] = NormalRamp(z);
    }
  }

  /// To 1e-8. @param z in standard deviations.
  double operator()(double z) const {
    if (z <= -kEnd) return 0;
    if (z >= kEnd) return 0.5 * (z * z + 1);
    const double at = (z + kEnd) / kStep;
    const std::size_t i = static_cast<std::size_t>(at);
    const double t = at - static_cast<double>(i), u = 1 - t;
    return u * u * ((1 + 2 * t) * value_[i] + t * kStep * slope_[i]) +
           t * t * ((1 + 2 * u) * value_[i + 1] - u * kStep * slope_[i + 1]);
  }

 private:
  static constexpr double kEnd = 6, kStep = 1.0 / 32;
  static constexpr int kEntries = 2 * 6 * 32 + 2;

  std::array<double, kEntries> value_, slope_;
};

/// Columns: what the kernel's six terms are worth at the samples.
Eigen::Matrix<double, kProfileSamples, EdgeTerms::kTerms> TermsAtSamples() {
  Eigen::Matrix<double, kProfileSamples, EdgeTerms::kTerms> terms;
  for (int i = 0; i < kProfileSamples; ++i) {
    const double a = (i + 1) * kProfileStep;
    double power = std::exp(-0.5 * a * a);
    for (int term = 0; term < EdgeTerms::kTerms; ++term) terms(i, term) = power *= a;
  }
  return terms;
}

/// Of samples of what lies beyond an edge, less half a Gaussian's density, the terms of least squares.
struct TermsFromSamples {
  using Solution = Eigen::Matrix<double, EdgeTerms::kTerms, kProfileSamples>;
  Solution solution = Solution::Zero();

  TermsFromSamples() {
    const auto terms = TermsAtSamples();
    solution = SmallCholesky<EdgeTerms::kTerms>(terms.transpose() * terms).SolveEach(terms.transpose());
  }
};

/// From upright (0) to 45 degrees; images know no left, right, up or down.
double SlantOf(const Eigen::Vector2d& normal) {
  const Eigen::Array2d size = normal.array().abs();
  return std::atan2(size.minCoeff(), size.maxCoeff());
}

/// What a blur is made of.
struct Parts {
  double neighbour = 0;  ///< what a pixel takes up of the next one along an axis
  double lens_px = 0;    ///< standard deviation
};

Parts PartsOf(const EdgeSpread& shape) {
  const double spread = std::max(shape.blur_px * shape.blur_px - kPixelVariance, kLeastVariance);
  return {0.5 * shape.filter * spread, std::max(std::sqrt(std::max(spread * (1 - shape.filter), 0.0)), kSharpest)};
}

/// A filter, its χ² with the best blur, and how much larger that is.
struct Try {
  double filter = 0, chi_square = 0, blur_px = 0;
};

Try TryOf(double filter, std::span<const Hidden> hidden, const BoardPixels& pixels) {
  double residual_square = 0, blur_residual = 0, blur_square = 0;
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (hidden[static_cast<std::size_t>(corner)] != Hidden::kNot) continue;
    for (int lane = pixels.Lane(corner); lane < pixels.Lane(corner) + 4; ++lane) {
      const auto sum = [&](int a, int b) { return static_cast<double>(pixels.lanes().sum(ProductSum(a, b), lane)); };
      residual_square += sum(kResidual, kResidual);
      blur_residual += sum(kBlur, kResidual);
      blur_square += sum(kBlur, kBlur);
    }
  }
  if (!(blur_square > 0)) return {filter, residual_square, 0};
  return {filter, residual_square - blur_residual * blur_residual / blur_square, blur_residual / blur_square};
}

/// Where the parabola through three, in order, is lowest, no farther than they are.
double Lowest(const std::array<Try, 3>& tries) {
  const auto& [a, b, c] = tries;
  const std::optional<Parabola> parabola =
      ParabolaThrough({{{a.filter, a.chi_square}, {b.filter, b.chi_square}, {c.filter, c.chi_square}}});
  if (!parabola) return a.chi_square < c.chi_square ? a.filter : c.filter;
  return std::clamp(parabola->at, a.filter, c.filter);
}

/// χ² is no parabola: where it is lowest is tried, and then between the three around.
template <class Evaluate>
Try BestOf(std::array<Try, 3> tries, double enough, const Evaluate& evaluate) {
  for (int round = 0; round < 2; ++round) {
    const double filter = Lowest(tries);
    const auto near = [&](const Try& t) { return std::abs(t.filter - filter) < kNearFilter; };
    if (std::any_of(tries.begin(), tries.end(), near)) break;
    const Try next = evaluate(filter);
    tries = filter < tries[1].filter ? std::array{tries[0], next, tries[1]} : std::array{tries[1], next, tries[2]};
    if (next.chi_square > enough) break;
  }
  return *std::min_element(tries.begin(), tries.end(),
                           [](const Try& a, const Try& b) { return a.chi_square < b.chi_square; });
}

}  // namespace

double EdgeProfile(const EdgeSpread& shape, const Eigen::Vector2d& normal, double distance_px) {
  const Parts parts = PartsOf(shape);
  const double neighbour = parts.neighbour;
  const Eigen::Array2d across = normal.normalized().array().abs().max(kLeastAcross);
  // The pixel's square, thrice, is steps up and down by these along each axis.
  const std::array<double, 4> at{-1.5, -0.5, 0.5, 1.5},
      step{neighbour, 1 - 3 * neighbour, 3 * neighbour - 1, -neighbour};
  static const Ramp ramp;
  double light = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      light += step[i] * step[j] * ramp((distance_px - at[i] * across.x() - at[j] * across.y()) / parts.lens_px);
  return light * parts.lens_px * parts.lens_px / across.prod();
}

EdgeTerms TermsOfProfile(const std::array<double, kProfileSamples>& beyond) {
  static const TermsFromSamples from;
  Eigen::Matrix<double, kProfileSamples, 1> less_gaussian;
  for (int i = 0; i < kProfileSamples; ++i) {
    const double a = (i + 1) * kProfileStep;
    less_gaussian[i] = beyond[static_cast<std::size_t>(i)] - 0.5 * std::exp(-0.5 * a * a);
  }
  EdgeTerms terms;
  Eigen::Map<Eigen::Matrix<float, EdgeTerms::kTerms, 1>>(terms.by_power.data()) =
      (from.solution * less_gaussian).cast<float>();
  return terms;
}

EdgeTerms TermsOf(const EdgeSpread& shape, const Eigen::Vector2d& normal) {
  if (shape.blur_px <= 0) return {};
  std::array<double, kProfileSamples> beyond;
  for (std::size_t i = 0; i < beyond.size(); ++i)
    beyond[i] = 1 - EdgeProfile(shape, normal, static_cast<double>(i + 1) * kProfileStep * shape.blur_px);
  return TermsOfProfile(beyond);
}

CornerExcess CornerExcessOf(const EdgeSpread& shape, const Eigen::Vector2d& normal_x) {
  if (shape.blur_px <= 0) return {};
  const Parts parts = PartsOf(shape);
  const double size =
      std::clamp(parts.neighbour / kFullFilter, 0.0, 1.0) * std::exp(-kLensLessens * parts.lens_px * parts.lens_px);
  // Of twice the angle.
  const Eigen::Vector2d across = normal_x.normalized();
  const double cosine = across.x() * across.x() - across.y() * across.y(), sine = 2 * across.x() * across.y();
  return {static_cast<float>(kCornerSquare * size * 2 * sine * cosine),
          static_cast<float>(kCornerProduct * size * sine * sine)};
}

void EdgeProfiles::Set(const EdgeSpread& shape) {
  if (shape == shape_) return;
  shape_ = shape;
  nodes_.fill(std::nullopt);
}

const EdgeTerms& EdgeProfiles::Node(int node) {
  std::optional<EdgeTerms>& terms = nodes_[static_cast<std::size_t>(node)];
  const double slant = node * (std::numbers::pi / 4 / (kNodes - 1));
  if (!terms) terms = TermsOf(shape_, {std::cos(slant), std::sin(slant)});
  return *terms;
}

EdgeTerms EdgeProfiles::Across(const Eigen::Vector2d& normal) {
  if (shape_.blur_px <= 0) return {};
  const double at = SlantOf(normal) / (std::numbers::pi / 4) * (kNodes - 1);
  const int node = std::clamp(static_cast<int>(at), 0, kNodes - 2);
  const float part = static_cast<float>(at - node);
  EdgeTerms terms = Node(node);
  const EdgeTerms& next = Node(node + 1);
  for (std::size_t i = 0; i < terms.by_power.size(); ++i)
    terms.by_power[i] += part * (next.by_power[i] - terms.by_power[i]);
  return terms;
}

std::optional<EdgeSpread> FindEdgeSpread(KernelInput input, const Eigen::Vector2d& normal_x,
                                         const Eigen::Vector2d& normal_y, std::span<const Hidden> hidden,
                                         BoardPixels& pixels) {
  LaneBlock& lanes = pixels.lanes();
  int count = 0;
  for (int lane = 0; lane < lanes.lanes(); ++lane) count += lanes.count(lane);
  // Weights that follow the model would make χ² no parabola.
  LevelNoise(lanes);
  input.stride = std::max(1, count / kPixels);
  input.sums = LaneSums::kShapes;
  const bool alike = std::abs(SlantOf(normal_x) - SlantOf(normal_y)) < kAlikeSlant;
  const auto evaluate_as = [&](const EdgeSpread& shape) {
    input.edge_x = TermsOf(shape, normal_x);
    input.edge_y = alike ? input.edge_x : TermsOf(shape, normal_y);
    input.corner = CornerExcessOf(shape, normal_x);
    AccumulateLanes(input, lanes);
    return TryOf(shape.filter, hidden, pixels);
  };
  const double blur_px = input.blur_px;
  const auto evaluate = [&](double filter) { return evaluate_as({blur_px, filter}); };
  // Without a filter, edges are nearly a Gaussian's.
  const Try gaussian = evaluate_as({}), smoothed = evaluate(kFilterStep);
  const double enough = gaussian.chi_square - kLeastGain / input.stride;
  const Try best =
      BestOf(smoothed.chi_square < gaussian.chi_square ? std::array{gaussian, smoothed, evaluate(2 * kFilterStep)}
                                                       : std::array{evaluate(-kFilterStep), gaussian, smoothed},
             enough, evaluate);
  if (best.chi_square > enough) return std::nullopt;
  return EdgeSpread{std::clamp(blur_px + best.blur_px, 0.8 * blur_px, 1.2 * blur_px), best.filter};
}

}  // namespace chequer
