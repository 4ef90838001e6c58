#include <gtest/gtest.h>

#include <bit>

#include "chequer/marker.h"
#include "support/seed.h"
#include "unit/marker/marker_codes.h"

namespace chequer {
namespace {

using test::AllCodes;
using test::AllSizes;
using test::Describe;

/// The only word within the guaranteed radius, looked for one word at a time.
std::optional<std::uint64_t> BruteForceId(const MarkerCode& code, const std::vector<std::uint64_t>& kernels,
                                          std::uint64_t kernel) {
  for (std::uint64_t id = 0; id < kernels.size(); ++id) {
    if (std::popcount(kernels[id] ^ kernel) <= code.guaranteed_radius()) return id;
  }
  return std::nullopt;
}

TEST(DecodeHard, AcceptsExactlyWhatLiesWithinTheRadius) {
  for (const MarkerSize size : {MarkerSize{3, 4}, {3, 5}, {4, 4}, {3, 7}, {4, 6}, {5, 5}}) {
    for (const MarkerCode& code : AllCodes(size)) {
      if (code.max_id() == 0) continue;
      std::vector<std::uint64_t> kernels;
      for (std::uint64_t id = 0; id <= code.max_id(); ++id) kernels.push_back(code.Encode(id));
      for (std::uint64_t kernel = 0; kernel < std::uint64_t{1} << KernelBits(size); ++kernel) {
        const std::optional<std::uint64_t> expected = BruteForceId(code, kernels, kernel);
        const std::optional<Decoded> decoded = code.DecodeHard(kernel);
        ASSERT_EQ(decoded.has_value(), expected.has_value()) << Describe(code) << " kernel " << kernel;
        if (!decoded) continue;
        ASSERT_EQ(decoded->id, *expected);
        ASSERT_EQ(decoded->kernel, kernels[*expected]);
        ASSERT_EQ(decoded->bits_corrected, std::popcount(kernel ^ decoded->kernel));
      }
    }
  }
}

/// Every kernel of 16 bits against every word, by the published radius.
void ExpectRadius(Variant variant, int radius) {
  const MarkerCode code({6, 6}, variant);
  ASSERT_EQ(code.guaranteed_radius(), radius);
  std::vector<std::uint64_t> kernels;
  for (std::uint64_t id = 0; id <= code.max_id(); ++id) kernels.push_back(code.Encode(id));
  for (std::uint64_t kernel = 0; kernel < 65536; ++kernel) {
    const std::optional<std::uint64_t> expected = BruteForceId(code, kernels, kernel);
    const std::optional<Decoded> decoded = code.DecodeHard(kernel);
    ASSERT_EQ(decoded.has_value(), expected.has_value()) << kernel;
    if (decoded) {
      ASSERT_EQ(decoded->id, *expected) << kernel;
    }
  }
}

TEST(DecodeHard, SecdedCorrectsOneOfSixteen) { ExpectRadius(Variant::kSecded, 1); }
TEST(DecodeHard, NordstromRobinsonCorrectsTwo) { ExpectRadius(Variant::kNordstromRobinson, 2); }
TEST(DecodeHard, ReedMullerCorrectsThree) { ExpectRadius(Variant::kReedMuller, 3); }

/// A pattern of `weight` of the lowest `bits` bits.
std::uint64_t RandomPattern(std::mt19937_64& random, int bits, int weight) {
  std::uint64_t pattern = 0;
  while (std::popcount(pattern) < weight) pattern |= std::uint64_t{1} << (random() % static_cast<std::uint64_t>(bits));
  return pattern;
}

TEST(DecodeHard, GuaranteesHoldAtEverySize) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : AllSizes()) {
    for (const MarkerCode& code : AllCodes(size)) {
      const int radius = code.guaranteed_radius();
      if (radius == 0 || code.max_id() == 0) continue;
      for (int trial = 0; trial < 50; ++trial) {
        const std::uint64_t id = std::uniform_int_distribution<std::uint64_t>(0, code.max_id())(random);
        const int wrong = static_cast<int>(random() % static_cast<std::uint64_t>(radius + 2));
        const std::uint64_t seen = code.Encode(id) ^ RandomPattern(random, KernelBits(size), wrong);
        const std::optional<Decoded> decoded = code.DecodeHard(seen);
        if (wrong <= radius) {
          ASSERT_TRUE(decoded.has_value()) << Describe(code);
          ASSERT_EQ(decoded->id, id) << Describe(code);
          ASSERT_EQ(decoded->bits_corrected, wrong) << Describe(code);
        } else {
          // One more than the radius: all distances here are even or larger, so it must be refused.
          ASSERT_FALSE(decoded.has_value()) << Describe(code);
        }
      }
    }
  }
}

TEST(DecodeHard, GolayCorrectsEveryPatternOfThree) {
  const MarkerCode code({6, 8}, Variant::kGolay);
  const std::uint64_t kernel = code.Encode(0xA5C);
  for (std::uint64_t pattern = 0; pattern < 1u << 24; ++pattern) {
    if (std::popcount(pattern) > 4) continue;
    const std::optional<Decoded> decoded = code.DecodeHard(kernel ^ pattern);
    ASSERT_EQ(decoded.has_value(), std::popcount(pattern) <= 3) << pattern;
    if (decoded) {
      ASSERT_EQ(decoded->id, 0xA5Cu);
    }
  }
}

TEST(DecodeHard, SpareCellsCountAmongTheWrongOnes) {
  const MarkerCode code({8, 8}, Variant::kGolay);
  const std::uint64_t kernel = code.Encode(99);
  EXPECT_EQ(code.DecodeHard(kernel ^ 0b111).value().bits_corrected, 3);
  EXPECT_FALSE(code.DecodeHard(kernel ^ 0b1111).has_value());
  EXPECT_FALSE(code.DecodeHard(kernel ^ 0b111 ^ (std::uint64_t{1} << 35)).has_value());
}

TEST(DecodeHard, RefusesBitsBeyondTheKernel) {
  for (const MarkerCode& code : AllCodes({6, 6})) {
    EXPECT_FALSE(code.DecodeHard(code.Encode(3) | 1u << 16).has_value()) << Describe(code);
  }
}

}  // namespace
}  // namespace chequer
