#include "simulate/traffic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulate/stopping.h"
#include "support/error_of.h"

namespace chequer {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;

/// What a disc is allowed to come nearer than its radius says: less than the gap that radii contain.
constexpr double kSlackM = 0.002;

TrafficOptions SixteenIn(double width_m, double height_m, double radius_m = 0.08) {
  TrafficOptions options;
  options.radii_m.assign(16, radius_m);
  options.arena = {-0.5 * Vector2d(width_m, height_m), 0.5 * Vector2d(width_m, height_m)};
  options.outskirts = options.arena;
  return options;
}

/// By how much any two discs overlap at the most, at instants a millisecond apart.
double WorstOverlap(const Traffic& traffic, const TrafficOptions& options, double seconds) {
  double worst = -1;
  for (int ms = 0; ms < seconds * 1000; ++ms)
    for (std::size_t i = 1; i < traffic.size(); ++i) {
      const Vector2d here = traffic.At(i, 1e-3 * ms).position;
      for (std::size_t j = 0; j < i; ++j)
        worst = std::max(worst,
                         options.radii_m[i] + options.radii_m[j] - (traffic.At(j, 1e-3 * ms).position - here).norm());
    }
  return worst;
}

TEST(Traffic, NeverLetsTwoRobotsTouch) {
  constexpr double kSeconds = 12;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    // Little room, and fast ones: everybody must give way all the time.
    const TrafficOptions options = SixteenIn(1.6, 0.9);
    const Traffic traffic(options, {{4, 0.4, 0}, {4, 1.5, 0}, {4, 3, 0}}, seed);
    EXPECT_LT(WorstOverlap(traffic, options, kSeconds), kSlackM) << "seed " << seed;
  }
}

TEST(Traffic, NeverLetsTwoRobotsTouchWhereManyLeaveAndComeBack) {
  TrafficOptions options = SixteenIn(1.6, 0.9);
  options.outskirts = {Vector2d(-1.0, -0.7), Vector2d(1.0, 0.7)};
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Traffic traffic(options, {{2, 0.5, 0}, {5, 1, 0.6}, {3, 1.5, 0}}, seed);
    EXPECT_LT(WorstOverlap(traffic, options, 10), kSlackM) << "seed " << seed;
  }
}

TEST(Traffic, StaysInTheArenaUnlessItMayLeave) {
  TrafficOptions options = SixteenIn(2, 1.2);
  options.outskirts = {Vector2d(-1.3, -0.9), Vector2d(1.3, 0.9)};
  const Traffic traffic(options, {{3, 1, 0}, {6, 1, 0.5}, {6, 1, 0}}, 5);
  const auto outside = [&](double time_s) {
    int count = 0;
    for (std::size_t i = 0; i < traffic.size(); ++i) {
      const Vector2d place = traffic.At(i, time_s).position;
      count += options.arena.exteriorDistance(place) > 1e-3;
      EXPECT_LT(options.outskirts.exteriorDistance(place), 1e-3) << time_s;
    }
    return count;
  };
  int left = 0;
  for (double time_s = 0; time_s < 3; time_s += 0.05) EXPECT_EQ(outside(time_s), 0) << time_s;
  for (double time_s = 3; time_s < 9; time_s += 0.05) left = std::max(left, outside(time_s));
  EXPECT_GE(left, 2);
  EXPECT_EQ(outside(15), 0) << "they come back";
}

TEST(Traffic, DrivesAsFastAsTheRuleSaysAndNoFaster) {
  const Traffic traffic(SixteenIn(2, 1.2), {{3, 0.4, 0}, {3, 1.5, 0}}, 1);
  double slow = 0, fast = 0;
  for (double time_s = 0; time_s < 6; time_s += 0.01)
    for (std::size_t i = 0; i < traffic.size(); ++i) {
      double& most = time_s < 3 ? slow : fast;
      most = std::max(most, traffic.At(i, time_s).velocity.norm());
    }
  EXPECT_LE(slow, 0.4 + 1e-9);
  EXPECT_GT(slow, 0.3);
  EXPECT_LE(fast, 1.5 + 1e-9);
  EXPECT_GT(fast, 1.2);
}

TEST(Traffic, MovesSmoothly) {
  const TrafficOptions options = SixteenIn(2, 1.2);
  const Traffic traffic(options, {{4, 1.5, 0}}, 2);
  constexpr double kStep = 1e-3;
  for (std::size_t i = 0; i < traffic.size(); ++i)
    for (double time_s = kStep; time_s < 4; time_s += kStep) {
      const DiscState before = traffic.At(i, time_s - kStep), after = traffic.At(i, time_s);
      ASSERT_LE((after.velocity - before.velocity).norm(), options.acceleration_m_s2 * kStep + 1e-9);
      // The position is the integral of the velocity, also across the simulation's own steps.
      ASSERT_NEAR((after.position - before.position - kStep * 0.5 * (before.velocity + after.velocity)).norm(), 0,
                  3e-6);
      ASSERT_LE(std::abs(after.heading_rad - before.heading_rad), options.turn_rate_rad_s * kStep + 1e-9);
      ASSERT_LE(std::abs(after.turn_rate_rad_s - before.turn_rate_rad_s),
                options.turn_acceleration_rad_s2 * kStep + 1e-9);
    }
}

TEST(Traffic, IsTheSameForTheSameSeedAlone) {
  const Traffic a(SixteenIn(2, 1.2), {{2, 1, 0}}, 3), b(SixteenIn(2, 1.2), {{2, 1, 0}}, 3);
  const Traffic c(SixteenIn(2, 1.2), {{2, 1, 0}}, 4);
  EXPECT_EQ(a.At(7, 1.9).position, b.At(7, 1.9).position);
  EXPECT_NE(a.At(7, 1.9).position, c.At(7, 1.9).position);
}

TEST(Traffic, SaysWhereThereIsNoRoom) {
  EXPECT_THAT(test::ErrorOf([] { Traffic(SixteenIn(0.4, 0.2), {{1, 1, 0}}, 1); }), HasSubstr("16 robots find no room"));
  EXPECT_THAT(test::ErrorOf([] { Traffic(SixteenIn(-1, 1), {{1, 1, 0}}, 1); }), HasSubstr("no room"));
}

TEST(Stopping, SeesWhetherTwoCanStopInTime) {
  const auto disc = [](double x, double speed) {
    return DiscState{.position = {x, 0}, .velocity = {speed, 0}, .heading_rad = 0, .turn_rate_rad_s = 0};
  };
  // Each needs 1 / (2 · 5) = 0.1 m to stop from 1 m/s.
  EXPECT_TRUE(StopApart(disc(0, 1), disc(0.41, -1), 5, 0.2));
  EXPECT_FALSE(StopApart(disc(0, 1), disc(0.39, -1), 5, 0.2));
  EXPECT_TRUE(StopApart(disc(0, 1), disc(0.21, 1), 5, 0.2)) << "one behind the other";
  EXPECT_FALSE(StopApart(disc(0, 0), disc(0.19, 0), 5, 0.2));
  EXPECT_NEAR(StopOf(disc(0, 1), 5).x(), 0.1, 1e-12);
  EXPECT_NEAR(Braked(disc(0, 1), 5, 0.1).velocity.x(), 0.5, 1e-12);
  EXPECT_NEAR(Braked(disc(0, 1), 5, 9).position.x(), 0.1, 1e-12);
}

}  // namespace
}  // namespace chequer
