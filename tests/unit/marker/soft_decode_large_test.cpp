// Soft decoding where the words are too many to look through: each variant by the reasoning that makes its best and
// second best word known.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "chequer/marker.h"
#include "support/seed.h"
#include "unit/marker/brute_force.h"
#include "unit/marker/marker_codes.h"

namespace chequer {
namespace {

using test::AllSizes;
using test::CostOfKernel;
using test::RandomRatios;

/// The kernel bit of a cell.
std::uint64_t CellBit(MarkerSize size, int cell) { return std::uint64_t{1} << (KernelBits(size) - 1 - cell); }

TEST(DecodeSoftLarge, UnconstrainedIsTheSignOfEveryCell) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : AllSizes()) {
    const MarkerCode code(size, Variant::kUnconstrained);
    const std::vector<float> ratios = RandomRatios(random, KernelBits(size));
    const SoftDecoded decoded = code.DecodeSoft(ratios).value();
    EXPECT_EQ(CostOfKernel(ratios, decoded.best.kernel), 0.0);
    EXPECT_EQ(decoded.best.id, decoded.best.kernel);
    float least = std::abs(ratios[0]);
    for (const float ratio : ratios) least = std::min(least, std::abs(ratio));
    EXPECT_EQ(decoded.margin, static_cast<double>(least));
  }
}

/// Whether two cells may be swapped without leaving the variant.
bool InOneClass(const MarkerCode& code, int a, int b) {
  if (code.variant() == Variant::kSaturationConstrained) return true;
  const int cols = code.size().cols - 2;
  return (a / cols + a % cols - b / cols - b % cols) % 2 == 0;
}

// Words of one weight are the bases of a uniform matroid: one that no swap of two cells improves is the best, and the
// second best is one swap away.
TEST(DecodeSoftLarge, NoSwapImprovesAConstrainedWord) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : AllSizes()) {
    for (const Variant variant : {Variant::kSaturationConstrained, Variant::kColorConstrained}) {
      const MarkerCode code(size, variant);
      const std::vector<float> ratios = RandomRatios(random, KernelBits(size));
      const SoftDecoded decoded = code.DecodeSoft(ratios).value();
      ASSERT_EQ(code.Encode(decoded.best.id), decoded.best.kernel) << test::Describe(code);
      double least_loss = std::numeric_limits<double>::infinity();
      for (int a = 0; a < KernelBits(size); ++a) {
        for (int b = 0; b < KernelBits(size); ++b) {
          if ((decoded.best.kernel & CellBit(size, a)) == 0 || (decoded.best.kernel & CellBit(size, b)) != 0) continue;
          if (!InOneClass(code, a, b)) continue;
          const double loss = static_cast<double>(ratios[static_cast<std::size_t>(a)]) -
                              static_cast<double>(ratios[static_cast<std::size_t>(b)]);
          least_loss = std::min(least_loss, loss);
        }
      }
      ASSERT_GE(least_loss, 0.0) << test::Describe(code);
      ASSERT_EQ(decoded.margin, least_loss) << test::Describe(code);
    }
  }
}

/// The two least costs of words that differ from the signs in at most four cells.
test::BruteForce::Costs CheapestWithinFour(const MarkerCode& code, std::span<const float> ratios, std::uint64_t signs) {
  const int n = KernelBits(code.size());
  constexpr double kNone = std::numeric_limits<double>::infinity();
  test::BruteForce::Costs costs{kNone, kNone};
  const auto consider = [&](std::uint64_t kernel) {
    const std::optional<Decoded> decoded = code.DecodeHard(kernel);
    if (!decoded || decoded->bits_corrected != 0) return;
    const double cost = CostOfKernel(ratios, kernel);
    costs.second = std::min(costs.second, std::max(costs.best, cost));
    costs.best = std::min(costs.best, cost);
  };
  consider(signs);
  for (int a = 0; a < n; ++a) {
    const std::uint64_t one = signs ^ std::uint64_t{1} << a;
    consider(one);
    for (int b = a + 1; b < n; ++b) {
      const std::uint64_t two = one ^ std::uint64_t{1} << b;
      consider(two);
      for (int c = b + 1; c < n; ++c) {
        const std::uint64_t three = two ^ std::uint64_t{1} << c;
        consider(three);
        for (int d = c + 1; d < n; ++d) consider(three ^ std::uint64_t{1} << d);
      }
    }
  }
  return costs;
}

// Of the extended Hamming code, every kernel has a word within two cells, and a second within four. With all
// reliabilities in 1 … 1.2 nothing beyond four cells can be cheaper than what lies within.
TEST(DecodeSoftLarge, SecdedOfSixtyFourCellsIsMaximumLikelihood) {
  std::mt19937_64 random = test::SeededGenerator();
  const MarkerCode code({10, 10}, Variant::kSecded);
  std::uniform_real_distribution<float> reliability(1.0f, 1.2f);
  for (int trial = 0; trial < 12; ++trial) {
    std::uint64_t signs = code.Encode(random() % (code.max_id() + 1));
    for (int wrong = 0; wrong < trial % 4; ++wrong) signs ^= std::uint64_t{1} << (random() % 64);
    std::vector<float> ratios;
    for (int bit = 63; bit >= 0; --bit)
      ratios.push_back((signs >> bit & 1) != 0 ? reliability(random) : -reliability(random));
    const test::BruteForce::Costs expected = CheapestWithinFour(code, ratios, signs);
    const SoftDecoded decoded = code.DecodeSoft(ratios).value();
    EXPECT_NEAR(CostOfKernel(ratios, decoded.best.kernel), expected.best, 1e-9) << "trial " << trial;
    EXPECT_NEAR(decoded.margin, expected.second - expected.best, 1e-9) << "trial " << trial;
    EXPECT_EQ(code.Encode(decoded.best.id), decoded.best.kernel);
  }
}

TEST(DecodeSoftLarge, SecdedFillsErasuresAndWeakErrorsAtEverySize) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : AllSizes()) {
    const MarkerCode code(size, Variant::kSecded);
    if (code.max_id() == 0) continue;
    const std::uint64_t id = std::uniform_int_distribution<std::uint64_t>(0, code.max_id())(random);
    const std::uint64_t kernel = code.Encode(id);
    std::vector<float> ratios;
    for (int cell = 0; cell < KernelBits(size); ++cell)
      ratios.push_back((kernel & CellBit(size, cell)) != 0 ? 4.0f : -4.0f);
    // Three cells, the most that any word of distance 4 survives: erased, erased, weakly wrong.
    std::vector<std::size_t> cells(ratios.size());
    for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = i;
    std::shuffle(cells.begin(), cells.end(), random);
    ratios[cells[0]] = 0.0f;
    ratios[cells[1]] = 0.0f;
    ratios[cells[2]] *= -0.25f;
    const SoftDecoded decoded = code.DecodeSoft(ratios).value();
    EXPECT_EQ(decoded.best.id, id) << ToString(size);
    EXPECT_EQ(decoded.best.bits_corrected, 1) << ToString(size);
    EXPECT_GE(decoded.margin, 3.0) << ToString(size);
  }
}

}  // namespace
}  // namespace chequer
