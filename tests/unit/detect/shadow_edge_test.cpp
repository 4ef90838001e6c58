#include "detect/fit/shadow_edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace chequer {
namespace {

/// The parts of the light cells of a board of 6 × 6, white ones and, every third, yellow ones, in some light.
template <class Light>
std::vector<LitPart> PartsIn(const Light& light, double noise) {
  std::mt19937 random(7);
  std::normal_distribution<double> error(0, noise);
  std::vector<LitPart> parts;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x) {
      const int row = y / 2, col = x / 2;
      if ((row + col) % 2 == 0) continue;
      const bool saturated = (2 * row + col) % 3 == 0;
      const Eigen::Vector2d middle(0.5 * x - 2.75, 0.5 * y - 2.75);
      parts.push_back({middle, (saturated ? 0.55 : 0.7) * light(middle) + error(random), saturated});
    }
  return parts;
}

ShadowEdge EdgeOf(double takes, double direction, double offset, double width) {
  return ShadowEdge(ShadowEdge::Parameters(takes, direction, offset, std::log(width)));
}

TEST(ShadowEdge, FallsAcrossItsLine) {
  const ShadowEdge edge = EdgeOf(0.6, std::numbers::pi / 2, 1, 0.5);
  EXPECT_NEAR(edge.At({0.3, -2}), 1, 1e-5);
  EXPECT_NEAR(edge.At({-2, 1}), 0.7, 1e-5);
  EXPECT_NEAR(edge.At({2, 4}), 0.4, 1e-5);
  EXPECT_NEAR(edge.At({0, 1.5}), 1 - 0.6 * 0.841345, 1e-5);
}

TEST(ShadowEdge, DerivativesAreThoseOfDifferences) {
  const ShadowEdge edge = EdgeOf(0.6, 0.7, 0.4, 0.5);
  // Long enough to span the nodes of a table.
  constexpr double kStep = 0.02;
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(0.1, 0.2), Eigen::Vector2d(1.2, -0.4), Eigen::Vector2d(-0.5, 1.6)}) {
    for (int k = 0; k < ShadowEdge::kParameters; ++k) {
      const ShadowEdge::Parameters step = kStep * ShadowEdge::Parameters::Unit(k);
      const ShadowEdge more(edge.values() + step), less(edge.values() - step);
      EXPECT_NEAR(edge.ByParameters(at)[k], (more.At(at) - less.At(at)) / (2 * kStep), 2e-3) << "parameter " << k;
    }
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      EXPECT_NEAR(edge.SlopeAt(at)[axis], (edge.At(at + step) - edge.At(at - step)) / (2 * kStep), 2e-3);
    }
  }
}

TEST(FindShadowEdge, FindsEdgesOfAllDirections) {
  for (const double width : {0.1, 0.4, 0.9})
    for (const double takes : {0.2, 0.6, 0.9})
      for (double direction = -3; direction <= 3; direction += 0.75) {
        const ShadowEdge edge = EdgeOf(takes, direction, 0.8, width);
        const auto found = FindShadowEdge(PartsIn([&](const Eigen::Vector2d& at) { return edge.At(at); }, 0.005));
        ASSERT_TRUE(found) << "width " << width << " takes " << takes << " direction " << direction;
        // Half a cell of light to a part: a tenth of a cell of a sharp edge's place is lost in it.
        for (double y = -2.5; y <= 2.5; y += 0.5)
          for (double x = -2.5; x <= 2.5; x += 0.5) {
            const Eigen::Vector2d at(x, y);
            const double from_edge = x * std::cos(direction) + y * std::sin(direction) - 0.8;
            if (std::abs(from_edge) < 0.4) continue;
            EXPECT_NEAR(found->At(at), edge.At(at), 0.06)
                << "at " << at.transpose() << ", width " << width << " takes " << takes << " direction " << direction;
          }
      }
}

TEST(FindShadowEdge, SeesNoneInEvenLight) {
  EXPECT_FALSE(FindShadowEdge(PartsIn([](const Eigen::Vector2d&) { return 1.0; }, 0.005)));
}

TEST(FindShadowEdge, SeesNoneInLightThatFallsOff) {
  EXPECT_FALSE(FindShadowEdge(PartsIn([](const Eigen::Vector2d& at) { return 1 - 0.12 * at.x(); }, 0.005)));
}

TEST(FindShadowEdge, SeesNoneInFewParts) {
  const ShadowEdge edge = EdgeOf(0.6, 0.7, 0.4, 0.5);
  std::vector<LitPart> parts = PartsIn([&](const Eigen::Vector2d& at) { return edge.At(at); }, 0);
  parts.resize(15);
  EXPECT_FALSE(FindShadowEdge(parts));
  EXPECT_FALSE(FindShadowEdge({}));
}

}  // namespace
}  // namespace chequer
