// Corners of chessboards against where they were drawn.
#include "lens/crossing_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulate/random.h"

namespace chequer {
namespace {

struct Drawn {
  Eigen::Vector2d at{20.3, 19.6};
  double first = 0.3, second = 1.7;  ///< angles of the edges, radians
  double blur_px = 0.8, noise = 2, gamma = 1;
  double light_slope = 0;  ///< of the paper, a pixel
};

double Side(double across, double blur) { return std::erf(across / blur / std::sqrt(2.0)); }

BytePlane Draw(const Drawn& drawn, Random& random) {
  BytePlane plane;
  plane.Resize(40, 40);
  for (int y = 0; y < plane.height(); ++y)
    for (int x = 0; x < plane.width(); ++x) {
      const double dx = x - drawn.at.x(), dy = y - drawn.at.y();
      const auto across = [&](double angle) { return std::cos(angle) * dy - std::sin(angle) * dx; };
      const double shape = Side(across(drawn.first), drawn.blur_px) * Side(across(drawn.second), drawn.blur_px);
      const double light = (0.45 + 0.4 * shape) * (1 + drawn.light_slope * dx);
      const double code = 255 * std::pow(light, 1 / drawn.gamma) + drawn.noise * random.Normal();
      plane.row(y)[x] = static_cast<std::uint8_t>(std::clamp(std::lround(code), 0L, 255L));
    }
  return plane;
}

CrossingStart Start(const Drawn& drawn, const Eigen::Vector2d& off) { return {drawn.at + off, {1, 0.1}, {0.1, 1}, 10}; }

double Rms(const Drawn& drawn, const Eigen::Vector2d& off) {
  Random random(7);
  double square = 0;
  constexpr int kTries = 50;
  for (int i = 0; i < kTries; ++i) {
    const auto found = FitCrossing(Draw(drawn, random), Start(drawn, off));
    EXPECT_TRUE(found);
    if (!found) return 1e9;
    square += (found->at - drawn.at).squaredNorm() / 2;
  }
  return std::sqrt(square / kTries);
}

TEST(CrossingFit, IsAsExactAsNoiseLets) {
  // Least squares: sigma^2 is noise^2 over the sum of squared slopes along one edge of 20 px, contrast 102 levels.
  EXPECT_LT(Rms({}, {0.4, -0.3}), 0.008);
  EXPECT_LT(Rms({.noise = 0.3}, {0.4, -0.3}), 0.002);
}

TEST(CrossingFit, IsMovedByNoToneCurveBlurOrSlopeOfTheLight) {
  EXPECT_LT(Rms({.noise = 1, .gamma = 2.2}, {0.4, -0.3}), 0.006);
  EXPECT_LT(Rms({.blur_px = 0.4}, {0.4, -0.3}), 0.008);
  EXPECT_LT(Rms({.blur_px = 3}, {0.4, -0.3}), 0.02);
  EXPECT_LT(Rms({.light_slope = 0.01}, {0.4, -0.3}), 0.01);
}

TEST(CrossingFit, FindsItFromSomePixelsAway) {
  EXPECT_LT(Rms({}, {2, 1.5}), 0.008);
  EXPECT_LT(Rms({.blur_px = 1.5}, {-2.5, 1}), 0.01);
}

TEST(CrossingFit, FindsNoneInFlatOrNoisyPixelsOrOutsideTheImage) {
  Random random(3);
  BytePlane flat;
  flat.Resize(40, 40);
  for (int y = 0; y < 40; ++y) std::fill_n(flat.row(y), 40, 90);
  EXPECT_FALSE(FitCrossing(flat, Start({}, {0, 0})));
  EXPECT_FALSE(FitCrossing(Draw({}, random), {{500, -300}, {1, 0}, {0, 1}, 10}));
  EXPECT_FALSE(FitCrossing(Draw({}, random), {{NAN, 20}, {1, 0}, {0, 1}, 10}));
  EXPECT_FALSE(FitCrossing(Draw({}, random), {{20, 20}, {0, 0}, {0, 0}, 1}));
}

TEST(CrossingFit, SaysHowBadlyItFits) {
  Random random(5);
  const auto clean = FitCrossing(Draw({}, random), Start({}, {0, 0}));
  BytePlane covered = Draw({}, random);
  for (int y = 22; y < 32; ++y) std::fill_n(covered.row(y) + 18, 12, 250);
  const auto hidden = FitCrossing(covered, Start({}, {0, 0}));
  ASSERT_TRUE(clean);
  EXPECT_LT(clean->misfit, 0.03);
  EXPECT_TRUE(!hidden || hidden->misfit > 4 * clean->misfit);
}

}  // namespace
}  // namespace chequer
