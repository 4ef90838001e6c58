#include "marker/combinations.h"

#include <gtest/gtest.h>

#include <bit>

#include "support/seed.h"

namespace chequer {
namespace {

TEST(Combinations, BinomialsAreExactUpToSixtyFour) {
  EXPECT_EQ(Binomial(0, 0), 1u);
  EXPECT_EQ(Binomial(16, 8), 12870u);
  EXPECT_EQ(Binomial(64, 32), 1832624140942590534u);
  EXPECT_EQ(Binomial(64, 64), 1u);
  EXPECT_EQ(Binomial(3, 4), 0u);
}

TEST(Combinations, RanksCountNumbersOfEqualWeightUpwards) {
  for (int ones = 0; ones <= 12; ++ones) {
    std::uint64_t rank = 0;
    for (std::uint64_t number = 0; number < 1u << 12; ++number) {
      if (std::popcount(number) != ones) continue;
      ASSERT_EQ(RankAmongEqualWeight(number), rank);
      ASSERT_EQ(NumberOfRank(rank, 12, ones), number);
      ++rank;
    }
    EXPECT_EQ(rank, Binomial(12, ones));
  }
}

TEST(Combinations, RanksGoThereAndBackAtSixtyFourBits) {
  std::mt19937_64 random = test::SeededGenerator();
  const std::uint64_t last = Binomial(64, 32) - 1;
  EXPECT_EQ(NumberOfRank(last, 64, 32), 0xFFFFFFFF00000000u);
  for (int trial = 0; trial < 1000; ++trial) {
    const std::uint64_t rank = random() % (last + 1);
    const std::uint64_t number = NumberOfRank(rank, 64, 32);
    ASSERT_EQ(std::popcount(number), 32);
    ASSERT_EQ(RankAmongEqualWeight(number), rank);
  }
}

TEST(Combinations, GatherClosesUpAndScatterSpreads) {
  EXPECT_EQ(GatherBits(0b110100, 0b111100), 0b1101u);
  EXPECT_EQ(ScatterBits(0b1101, 0b111100), 0b110100u);
  EXPECT_EQ(GatherBits(0x8000000000000001, 0x8000000000000001), 0b11u);
  EXPECT_EQ(GatherBits(~std::uint64_t{0}, ~std::uint64_t{0}), ~std::uint64_t{0});
  EXPECT_EQ(ScatterBits(~std::uint64_t{0}, 0), 0u);
}

}  // namespace
}  // namespace chequer
