#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>

#include "chequer/marker.h"
#include "support/seed.h"
#include "unit/marker/brute_force.h"
#include "unit/marker/marker_codes.h"

namespace chequer {
namespace {

using test::AllCodes;
using test::BruteForce;
using test::Describe;
using test::ExpectMostLikely;
using test::RandomRatios;

TEST(DecodeSoft, IsMaximumLikelihoodAtSixBySix) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerCode& code : AllCodes({6, 6})) {
    const BruteForce reference(code);
    const int trials = code.max_id() > 10000 ? 60 : 600;
    for (int trial = 0; trial < trials; ++trial) {
      const std::vector<float> ratios = RandomRatios(random, KernelBits(code.size()));
      ExpectMostLikely(code, reference, ratios, code.DecodeSoft(ratios));
      if (testing::Test::HasFailure()) FAIL() << Describe(code) << " trial " << trial;
    }
  }
}

TEST(DecodeSoft, IsMaximumLikelihoodAtOtherSizes) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : {MarkerSize{3, 3},
                                {3, 4},
                                {3, 5},
                                {4, 4},
                                {3, 7},
                                {5, 5},
                                {4, 6},
                                {3, 13},
                                {5, 6},
                                {4, 8},
                                {5, 7},
                                {4, 10},
                                {3, 18},
                                {6, 7},
                                {6, 8},
                                {8, 8},
                                {10, 10}}) {
    for (const MarkerCode& code : AllCodes(size)) {
      if (code.max_id() > 70000) continue;
      const BruteForce reference(code);
      const int trials = code.max_id() > 10000 ? 20 : 150;
      for (int trial = 0; trial < trials; ++trial) {
        const std::vector<float> ratios = RandomRatios(random, KernelBits(size));
        ExpectMostLikely(code, reference, ratios, code.DecodeSoft(ratios));
        if (testing::Test::HasFailure()) FAIL() << Describe(code) << " trial " << trial;
      }
    }
  }
}

TEST(DecodeSoft, IsMaximumLikelihoodForTables) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : {MarkerSize{3, 5}, {4, 5}, {6, 6}, {5, 8}, {8, 8}, {9, 9}, {10, 10}}) {
    const std::uint64_t all = ~std::uint64_t{0} >> (64 - KernelBits(size));
    for (const std::size_t entries : {1u, 2u, 5u, 300u}) {
      std::set<std::uint64_t> kernels;
      while (kernels.size() < std::min<std::uint64_t>(entries, all)) kernels.insert(random() & all);
      const MarkerCode code = MarkerCode::FromTable(size, {kernels.begin(), kernels.end()});
      const BruteForce reference(code);
      for (int trial = 0; trial < 100; ++trial) {
        const std::vector<float> ratios = RandomRatios(random, KernelBits(size));
        ExpectMostLikely(code, reference, ratios, code.DecodeSoft(ratios));
        if (testing::Test::HasFailure()) FAIL() << ToString(size) << " entries " << entries << " trial " << trial;
      }
    }
  }
}

TEST(DecodeSoft, ErasedCellsDecideAndCorrectNothing) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  const std::uint64_t id = 1234;
  const std::uint64_t kernel = code.Encode(id);
  std::vector<float> ratios(16);
  for (std::size_t cell = 0; cell < 16; ++cell) ratios[cell] = (kernel >> (15 - cell) & 1) != 0 ? 5.0f : -5.0f;
  // Three erasures are filled, the distance being 4: any other word differs in one more cell at least.
  ratios[0] = ratios[7] = ratios[12] = 0.0f;
  const SoftDecoded filled = code.DecodeSoft(ratios).value();
  EXPECT_EQ(filled.best.id, id);
  EXPECT_EQ(filled.best.kernel, kernel);
  EXPECT_EQ(filled.best.bits_corrected, 0);
  EXPECT_DOUBLE_EQ(filled.margin, 5.0);
  // In the place of one of them, a cell that is wrong.
  ratios[12] = (kernel >> 3 & 1) != 0 ? -4.0f : 4.0f;
  const SoftDecoded corrected = code.DecodeSoft(ratios).value();
  EXPECT_EQ(corrected.best.id, id);
  EXPECT_EQ(corrected.best.bits_corrected, 1);
  EXPECT_DOUBLE_EQ(corrected.margin, 1.0);
}

TEST(DecodeSoft, NothingSeenLeavesNoMargin) {
  const std::vector<float> ratios(16, 0.0f);
  for (const MarkerCode& code : AllCodes({6, 6})) {
    const SoftDecoded decoded = code.DecodeSoft(ratios).value();
    EXPECT_EQ(decoded.margin, 0.0) << Describe(code);
    EXPECT_EQ(decoded.best.bits_corrected, 0) << Describe(code);
    EXPECT_EQ(code.Encode(decoded.best.id), decoded.best.kernel) << Describe(code);
  }
}

TEST(DecodeSoft, OneWordAloneHasNoSecond) {
  for (const Variant variant : {Variant::kSecded, Variant::kSaturationConstrained, Variant::kColorConstrained}) {
    const MarkerCode code({3, 3}, variant);
    const SoftDecoded decoded = code.DecodeSoft(std::array{0.5f}).value();
    EXPECT_EQ(decoded.best.id, 0u);
    EXPECT_EQ(decoded.margin, std::numeric_limits<double>::infinity()) << VariantName(variant);
  }
}

TEST(DecodeSoft, SurvivesTheLargestFiniteRatios) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  for (const MarkerSize size : {MarkerSize{6, 6}, {10, 10}}) {
    for (const MarkerCode& code : AllCodes(size)) {
      const std::uint64_t kernel = code.Encode(code.max_id() / 3);
      std::vector<float> ratios;
      for (int bit = KernelBits(size) - 1; bit >= 0; --bit)
        ratios.push_back((kernel >> bit & 1) ? kLargest : -kLargest);
      const SoftDecoded decoded = code.DecodeSoft(ratios).value();
      EXPECT_EQ(decoded.best.id, code.max_id() / 3) << Describe(code);
      EXPECT_TRUE(std::isfinite(decoded.margin)) << Describe(code);
      EXPECT_GE(decoded.margin, static_cast<double>(kLargest)) << Describe(code);
    }
  }
}

TEST(DecodeSoftDeathTest, AWrongCountOrAnUndefinedRatioIsABug) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  std::vector<float> ratios(15, 1.0f);
  EXPECT_DEATH(static_cast<void>(code.DecodeSoft(ratios)), "one ratio a kernel cell");
  ratios.push_back(std::numeric_limits<float>::quiet_NaN());
  EXPECT_DEATH(static_cast<void>(code.DecodeSoft(ratios)), "not finite");
}

}  // namespace
}  // namespace chequer
