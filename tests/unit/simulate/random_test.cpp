#include "simulate/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace chequer {
namespace {

struct Moments {
  double mean = 0;
  double variance = 0;
};

template <typename Draw>
Moments Measure(int count, Draw draw) {
  double sum = 0, squares = 0;
  for (int i = 0; i < count; ++i) {
    const double value = draw();
    sum += value;
    squares += value * value;
  }
  const double mean = sum / count;
  return {mean, squares / count - mean * mean};
}

TEST(Random, SameSeedSameStream) {
  Random a(42), b(42), other(43);
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t bits = a.Bits();
    EXPECT_EQ(bits, b.Bits());
    EXPECT_NE(bits, other.Bits());
  }
}

TEST(Random, NormalHasMeanZeroAndVarianceOne) {
  Random random(1);
  const Moments m = Measure(400000, [&] { return static_cast<double>(random.Normal()); });
  EXPECT_NEAR(m.mean, 0, 5 / std::sqrt(400000.0));
  EXPECT_NEAR(m.variance, 1, 5 * std::sqrt(2 / 400000.0));
}

TEST(Random, NormalReachesItsQuantiles) {
  Random random(2);
  constexpr int kCount = 400000;
  int beyond_one = 0, beyond_three = 0;
  for (int i = 0; i < kCount; ++i) {
    const float value = random.Normal();
    beyond_one += value > 1;
    beyond_three += value > 3;
  }
  EXPECT_NEAR(beyond_one / double{kCount}, 0.158655, 0.003);
  EXPECT_NEAR(beyond_three / double{kCount}, 0.00135, 0.0003);
}

TEST(Random, PoissonHasItsMeanAsVarianceOnBothSidesOfTheSwitch) {
  for (const float mean : {0.3f, 4.0f, 49.0f, 51.0f, 900.0f}) {
    Random random(3);
    constexpr int kCount = 200000;
    const Moments m = Measure(kCount, [&] { return static_cast<double>(random.Poisson(mean)); });
    const double expected = static_cast<double>(mean);
    EXPECT_NEAR(m.mean, expected, 5 * std::sqrt(expected / kCount)) << mean;
    EXPECT_NEAR(m.variance / expected, 1, 0.02) << mean;
  }
}

TEST(Random, NothingComesFromNoLight) {
  Random random(4);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(random.Poisson(0), 0);
}

TEST(Random, BelowStaysBelow) {
  Random random(5);
  int seen[3] = {0, 0, 0};
  for (int i = 0; i < 3000; ++i) ++seen[random.Below(3)];
  for (const int count : seen) EXPECT_NEAR(count, 1000, 150);
}

TEST(Random, DerivedSeedsDiffer) {
  EXPECT_NE(DeriveSeed(1, 0), DeriveSeed(1, 1));
  EXPECT_NE(DeriveSeed(1, 0), DeriveSeed(2, 0));
  EXPECT_EQ(DeriveSeed(7, 9), DeriveSeed(7, 9));
}

}  // namespace
}  // namespace chequer
