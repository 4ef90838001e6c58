#include "bench/long_tally.h"

#include <gtest/gtest.h>

namespace chequer::bench {
namespace {

TEST(LogHistogram, KnowsQuantilesToAHundredth) {
  LogHistogram histogram;
  EXPECT_EQ(histogram.Quantile(0.5), 0);
  for (int i = 1; i <= 1000; ++i) histogram.Add(0.37 * i);
  EXPECT_EQ(histogram.count(), 1000u);
  EXPECT_NEAR(histogram.mean(), 0.37 * 500.5, 1e-9);
  EXPECT_NEAR(histogram.Quantile(0.5), 0.37 * 500, 0.01 * 0.37 * 500);
  EXPECT_NEAR(histogram.Quantile(0.99), 0.37 * 990, 0.01 * 0.37 * 990);
  EXPECT_DOUBLE_EQ(histogram.largest(), 370);
  histogram.Add(0);
  histogram.Add(1e12);
  EXPECT_EQ(histogram.largest(), 1e12);
}

TEST(PhaseTally, CountsMistakesAndWhatWasRead) {
  PhaseTally tally;
  FrameScore good, bad;
  good.expected = good.read = 3;
  good.errors = {{.position_over_covariance = 0.5, .rotation_over_covariance = 2.0}, {}};
  bad.expected = 3;
  bad.read = 1;
  bad.wrong = 1;
  bad.ghosts = 2;
  tally.Add(good, 100, 0);
  EXPECT_EQ(tally.mistakes(), 0u);
  tally.Add(bad, 300, 2);
  EXPECT_EQ(tally.mistakes(), 3u);
  EXPECT_EQ(tally.frames, 2u);
  EXPECT_EQ(tally.expected, 6u);
  EXPECT_EQ(tally.read, 4u);
  EXPECT_EQ(tally.deferred, 2u);
  EXPECT_EQ(tally.position_over_covariance.count(), 1u);
  EXPECT_DOUBLE_EQ(tally.rotation_over_covariance.mean(), 2);
  EXPECT_DOUBLE_EQ(tally.work.mean(), 200);
}

TEST(MemoryWatch, SeesMemoryGrowOnlyAfterTheFirstTenth) {
  MemoryWatch flat, growing;
  for (std::uint64_t i = 0; i <= 100; ++i) {
    flat.Add(i * 1000, i < 5 ? 10 + static_cast<double>(i) : 15);
    growing.Add(i * 1000, 15 + 0.1 * static_cast<double>(i));
  }
  EXPECT_DOUBLE_EQ(flat.Growth(), 0);
  EXPECT_NEAR(growing.Growth(), 7, 1e-9);
  EXPECT_GT(ResidentMegabytes(), 1);
}

}  // namespace
}  // namespace chequer::bench
