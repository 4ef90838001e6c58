#include "detect/fit/shadow_edge.h"

#include <algorithm>
#include <cmath>

#include "core/small_cholesky.h"
#include "detect/common/normal_integral.h"

namespace chequer {
namespace {

constexpr std::size_t kFewestParts = 16;
/// A shadow takes as much at least, and leaves so much of what the parts differ by unexplained at most.
constexpr double kLeastTaken = 0.05, kLeavesUnexplained = 0.3;
/// Bounds of the parameters.
constexpr double kMostTaken = 0.98, kLeastLogWidth = -4, kMostLogWidth = 0.7;
/// Wider edges are no more than light that falls off.
constexpr double kLogWidthOfShading = 0.3;
/// Variance of the places within a part, cells².
constexpr double kPartVariance = 0.5 * 0.5 / 12;
/// Deviations beyond which an edge does not change.
constexpr double kNoSlope = 4.5;
constexpr int kEdgeSteps = 12;

ShadowEdge::Parameters WithinBounds(ShadowEdge::Parameters values) {
  values[ShadowEdge::kTakes] = std::clamp(values[ShadowEdge::kTakes], 0.0, kMostTaken);
  values[ShadowEdge::kLogWidth] = std::clamp(values[ShadowEdge::kLogWidth], kLeastLogWidth, kMostLogWidth);
  return values;
}

/// As parts of cells show it.
ShadowEdge Widened(ShadowEdge::Parameters values) {
  values[ShadowEdge::kLogWidth] = 0.5 * std::log(std::exp(2 * values[ShadowEdge::kLogWidth]) + kPartVariance);
  return ShadowEdge(values);
}

/// The light of both inks, then the edge.
constexpr int kLightUnknowns = 2 + ShadowEdge::kParameters;
using Unknowns = Eigen::Matrix<double, kLightUnknowns, 1>;

/// Σ of the squares that are left, with the normal equations if they are wanted.
double SquaresOf(std::span<const LitPart> parts, const Unknowns& x,
                 Eigen::Matrix<double, kLightUnknowns, kLightUnknowns>* normal, Unknowns* gradient) {
  const ShadowEdge::Parameters values = x.tail<ShadowEdge::kParameters>();
  const ShadowEdge edge = Widened(values);
  // The width shows the less the more of it is the parts' own.
  const double by_width = std::exp(2 * (values[ShadowEdge::kLogWidth] - edge.values()[ShadowEdge::kLogWidth]));
  double squares = 0;
  if (normal) normal->setZero(), gradient->setZero();
  for (const LitPart& part : parts) {
    const double share = edge.At(part.middle), left = part.light - x[part.saturated] * share;
    squares += left * left;
    if (!normal) continue;
    ShadowEdge::Parameters by_edge = edge.ByParameters(part.middle);
    by_edge[ShadowEdge::kLogWidth] *= by_width;
    Unknowns by = Unknowns::Zero();
    by[part.saturated] = share;
    by.tail<ShadowEdge::kParameters>() = x[part.saturated] * by_edge;
    *normal += by * by.transpose();
    *gradient += by * left;
  }
  return squares;
}

Unknowns KeptWithinBounds(Unknowns x) {
  x.tail<ShadowEdge::kParameters>() = WithinBounds(x.tail<ShadowEdge::kParameters>());
  return x;
}

/// Levenberg and Marquardt's steps. Returns the squares that are left.
double Refine(std::span<const LitPart> parts, Unknowns& x) {
  Eigen::Matrix<double, kLightUnknowns, kLightUnknowns> normal;
  Unknowns gradient;
  double squares = SquaresOf(parts, x, &normal, &gradient), damping = 0.01;
  for (int step = 0; step < kEdgeSteps; ++step) {
    Eigen::Matrix<double, kLightUnknowns, kLightUnknowns> damped = normal;
    damped.diagonal() = (1 + damping) * normal.diagonal().array() + 1e-9 * normal.diagonal().maxCoeff();
    const Unknowns tried = KeptWithinBounds(x + SmallCholesky<kLightUnknowns>(damped).Solve(gradient));
    const double left = tried.allFinite() ? SquaresOf(parts, tried, nullptr, nullptr) : 2 * squares;
    damping *= left < squares ? 0.2 : 10;
    if (left >= squares) continue;
    const bool settled = left > 0.999 * squares;
    x = tried;
    squares = SquaresOf(parts, x, &normal, &gradient);
    if (settled) break;
  }
  return squares;
}

/// Squares about the mean of each ink's parts.
double SquaresWithoutEdge(std::span<const LitPart> parts, Eigen::Vector2d& mean) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero(), square = sum, count = sum;
  for (const LitPart& part : parts) {
    sum[part.saturated] += part.light;
    square[part.saturated] += part.light * part.light;
    ++count[part.saturated];
  }
  mean = sum.array() / count.array().max(1);
  return (square.array() - sum.array() * mean.array()).sum();
}

/// Of the parts of each ink: their number, and the sum of their light.
struct Inks {
  Eigen::Array2d count = Eigen::Array2d::Zero(), light = Eigen::Array2d::Zero();
};

/// The light of both inks and what a shadow takes of it in its depth, by linear least squares, with the squares that
/// are left, less those of all light.
struct LinearFit {
  Eigen::Vector2d light = Eigen::Vector2d::Zero();
  double taken = 0, left = 0;
};

LinearFit FitLinearly(std::span<const LitPart> parts, const Inks& inks, const ShadowEdge& edge) {
  Eigen::Array2d depth = Eigen::Array2d::Zero();  // Σ of how deep the parts of each ink lie in the shadow
  double square = 1e-6, lit = 0;
  for (const LitPart& part : parts) {
    const double deep = edge.DepthAt(part.middle);
    depth[part.saturated] += deep;
    square += deep * deep;
    lit += deep * part.light;
  }
  // Without the light of the inks, which follows.
  const Eigen::Array2d mean_depth = depth / inks.count, mean_light = inks.light / inks.count;
  square -= (depth * mean_depth).sum();
  lit -= (depth * mean_light).sum();
  LinearFit fit;
  fit.taken = -lit / square;
  fit.light = mean_light + fit.taken * mean_depth;
  fit.left = -(inks.light * mean_light).sum() - lit * lit / square;
  return fit;
}

/// The best of some edges.
Unknowns Start(std::span<const LitPart> parts, const Eigen::Vector2d& mean) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero(), rise = middle;
  Inks inks;
  for (const LitPart& part : parts) {
    middle += part.middle / static_cast<double>(parts.size());
    ++inks.count[part.saturated];
    inks.light[part.saturated] += part.light;
  }
  inks.count = inks.count.max(1e-6);
  for (const LitPart& part : parts) rise += (part.light - mean[part.saturated]) * (part.middle - middle);
  const double darker = std::atan2(-rise.y(), -rise.x());
  Unknowns best = Unknowns::Zero();
  double least = 1e300;
  for (const double turn : {-0.5, 0.0, 0.5})
    for (const double log_width : {-1.5, -0.7, 0.0})
      for (double offset = -2.5, step = log_width < -1 ? 0.3 : 0.5; offset <= 2.5; offset += step) {
        const ShadowEdge::Parameters values(kMostTaken, darker + turn, offset, log_width);
        const LinearFit fit = FitLinearly(parts, inks, Widened(values));
        if (!(fit.left < least) || !(fit.taken > 0)) continue;
        least = fit.left;
        best << fit.light, fit.taken / std::max(fit.light.maxCoeff(), 1e-6), values.tail<3>();
      }
  return KeptWithinBounds(best);
}

}  // namespace

ShadowEdge::ShadowEdge(const Parameters& values)
    : values_(WithinBounds(values)),
      normal_(std::cos(values_[kDirection]), std::sin(values_[kDirection])),
      per_width_(std::exp(-values_[kLogWidth])) {}

double ShadowEdge::DepthAt(const Eigen::Vector2d& board) const { return NormalTable::Get()(Across(board)); }

double ShadowEdge::At(const Eigen::Vector2d& board) const { return 1 - values_[kTakes] * DepthAt(board); }

Eigen::Vector2d ShadowEdge::SlopeAt(const Eigen::Vector2d& board) const {
  const double z = Across(board);
  if (std::abs(z) > kNoSlope) return Eigen::Vector2d::Zero();
  return -values_[kTakes] * NormalDensity(z) * per_width_ * normal_;
}

ShadowEdge::Parameters ShadowEdge::ByParameters(const Eigen::Vector2d& board) const {
  const double z = Across(board), along = normal_.x() * board.y() - normal_.y() * board.x(),
               fall = std::abs(z) > kNoSlope ? 0 : values_[kTakes] * NormalDensity(z);
  Parameters by;
  by[kTakes] = -NormalTable::Get()(z);
  by[kDirection] = -fall * along * per_width_;
  by[kOffset] = fall * per_width_;
  by[kLogWidth] = fall * z;
  return by;
}

bool ShadowEdge::Crosses(const Eigen::Vector2d& board, double reach) const {
  return std::abs(Across(board)) < kNoSlope + reach * per_width_;
}

std::optional<ShadowEdge> FindShadowEdge(std::span<const LitPart> parts) {
  if (parts.size() < kFewestParts) return std::nullopt;
  Eigen::Vector2d mean;
  const double without = SquaresWithoutEdge(parts, mean);
  Unknowns x = Start(parts, mean);
  if (x[2 + ShadowEdge::kTakes] <= 0) return std::nullopt;
  const double with = Refine(parts, x);
  if (!(with < kLeavesUnexplained * without) || x[2 + ShadowEdge::kTakes] < kLeastTaken ||
      x[2 + ShadowEdge::kLogWidth] > kLogWidthOfShading)
    return std::nullopt;
  return ShadowEdge(x.tail<ShadowEdge::kParameters>());
}

}  // namespace chequer
