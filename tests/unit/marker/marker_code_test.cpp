#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <set>

#include "chequer/marker.h"
#include "support/error_of.h"
#include "support/seed.h"
#include "unit/marker/marker_codes.h"

namespace chequer {
namespace {

using test::AllCodes;
using test::AllSizes;
using test::Describe;

std::string MessageOf(MarkerSize size, Variant variant) {
  return test::ErrorOf([&] { const MarkerCode code(size, variant); });
}

TEST(Variant, NamesGoThereAndBack) {
  for (int i = 0; i <= static_cast<int>(Variant::kTable); ++i) {
    const auto variant = static_cast<Variant>(i);
    EXPECT_EQ(ParseVariant(VariantName(variant)), variant);
  }
  EXPECT_EQ(ParseVariant("SECDED"), std::nullopt);
  EXPECT_EQ(ParseVariant(""), std::nullopt);
}

TEST(MarkerCode, CountsOfIdsAreTheSpecifications) {
  EXPECT_EQ(MarkerCode({6, 6}, Variant::kUnconstrained).max_id(), 65535u);
  EXPECT_EQ(MarkerCode({6, 6}, Variant::kSaturationConstrained).max_id(), 12869u);
  EXPECT_EQ(MarkerCode({6, 6}, Variant::kColorConstrained).max_id(), 4899u);
  EXPECT_EQ(MarkerCode({6, 6}, Variant::kSecded).max_id(), 2047u);
  EXPECT_EQ(MarkerCode({6, 6}, Variant::kNordstromRobinson).max_id(), 255u);
  EXPECT_EQ(MarkerCode({6, 6}, Variant::kReedMuller).max_id(), 31u);
  EXPECT_EQ(MarkerCode({8, 8}, Variant::kGolay).max_id(), 4095u);
  EXPECT_EQ(MarkerCode({8, 8}, Variant::kUnconstrained).max_id(), (std::uint64_t{1} << 36) - 1);
  EXPECT_EQ(MarkerCode({10, 10}, Variant::kUnconstrained).max_id(), ~std::uint64_t{0});
  EXPECT_EQ(MarkerCode({10, 10}, Variant::kSecded).max_id(), (std::uint64_t{1} << 57) - 1);
  EXPECT_EQ(MarkerCode({10, 10}, Variant::kSaturationConstrained).max_id(), 1832624140942590533u);
  EXPECT_EQ(MarkerCode({10, 10}, Variant::kColorConstrained).max_id(), 601080390u * std::uint64_t{601080390} - 1);
  // Boards so small that a rule leaves one id.
  EXPECT_EQ(MarkerCode({3, 3}, Variant::kSecded).max_id(), 0u);
  EXPECT_EQ(MarkerCode({3, 3}, Variant::kUnconstrained).max_id(), 1u);
  EXPECT_EQ(MarkerCode({3, 4}, Variant::kColorConstrained).max_id(), 0u);
}

TEST(MarkerCode, RefusesWhatDoesNotExistAndSaysWhatWould) {
  using testing::HasSubstr;
  EXPECT_THAT(MessageOf({2, 6}, Variant::kSecded), testing::AllOf(HasSubstr("2x6"), HasSubstr("at least 3")));
  EXPECT_THAT(MessageOf({11, 11}, Variant::kSecded), testing::AllOf(HasSubstr("11x11"), HasSubstr("at most 64")));
  EXPECT_THAT(MessageOf({6, 6}, Variant::kGolay),
              testing::AllOf(HasSubstr("golay"), HasSubstr("6x6"), HasSubstr("at least 24"), HasSubstr("has 16")));
  EXPECT_THAT(MessageOf({8, 8}, Variant::kNordstromRobinson), HasSubstr("exactly 16"));
  EXPECT_THAT(MessageOf({5, 5}, Variant::kReedMuller), HasSubstr("exactly 16"));
  EXPECT_THAT(MessageOf({6, 6}, Variant::kTable), HasSubstr("kernels"));
  EXPECT_EQ(MessageOf({3, 18}, Variant::kReedMuller), "no error") << "16 kernel cells in another shape will do";
  EXPECT_EQ(MessageOf({6, 8}, Variant::kGolay), "no error") << "24 kernel cells are enough";
}

TEST(MarkerCodeDeathTest, AnIdBeyondTheLastIsABug) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  EXPECT_DEATH(static_cast<void>(code.Encode(2048)), "no such id");
}

/// The least distance between any two words, looked for one pair at a time.
int BruteForceDistance(const std::vector<std::uint64_t>& kernels, int bits) {
  int least = bits + 1;
  for (std::size_t i = 0; i < kernels.size(); ++i) {
    for (std::size_t j = i + 1; j < kernels.size(); ++j)
      least = std::min(least, std::popcount(kernels[i] ^ kernels[j]));
  }
  return least;
}

std::vector<std::uint64_t> AllKernels(const MarkerCode& code) {
  std::vector<std::uint64_t> kernels;
  for (std::uint64_t id = 0; id <= code.max_id(); ++id) kernels.push_back(code.Encode(id));
  return kernels;
}

TEST(MarkerCode, MinimalDistanceIsThatOfTheWords) {
  for (const MarkerSize size :
       {MarkerSize{3, 3}, {3, 4}, {3, 5}, {4, 4}, {3, 7}, {5, 5}, {4, 6}, {3, 12}, {6, 6}, {6, 8}}) {
    for (const MarkerCode& code : AllCodes(size)) {
      if (code.max_id() > 5000) continue;
      EXPECT_EQ(code.min_distance(), BruteForceDistance(AllKernels(code), KernelBits(size))) << Describe(code);
    }
  }
}

TEST(MarkerCode, SpareCellsAddToTheDistanceOfGolay) {
  EXPECT_EQ(MarkerCode({6, 8}, Variant::kGolay).min_distance(), 8);
  for (const MarkerSize size : {MarkerSize{8, 8}, {10, 10}}) {
    const MarkerCode code(size, Variant::kGolay);
    EXPECT_EQ(code.min_distance(), BruteForceDistance(AllKernels(code), KernelBits(size))) << ToString(size);
    EXPECT_GT(code.min_distance(), 8);
  }
}

TEST(MarkerCode, CorrectsNoMoreThanItsDistanceAllows) {
  for (const MarkerSize size : AllSizes()) {
    for (const MarkerCode& code : AllCodes(size)) {
      if (code.max_id() > 0) {
        EXPECT_LT(2 * code.guaranteed_radius(), code.min_distance()) << Describe(code);
      }
    }
  }
}

TEST(MarkerCode, EverySmallCodeIsABijection) {
  for (const MarkerSize size : AllSizes()) {
    if (size.rows > size.cols || size.cols > 10) continue;
    for (const MarkerCode& code : AllCodes(size)) {
      if (code.max_id() > 70000) continue;
      std::set<std::uint64_t> kernels;
      for (std::uint64_t id = 0; id <= code.max_id(); ++id) {
        const std::uint64_t kernel = code.Encode(id);
        ASSERT_EQ(code.DecodeHard(kernel).value().id, id) << Describe(code);
        kernels.insert(kernel);
      }
      EXPECT_EQ(kernels.size(), code.max_id() + 1) << Describe(code);
    }
  }
}

TEST(MarkerCode, LargeIdsGoThereAndBackAtEverySize) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : AllSizes()) {
    for (const MarkerCode& code : AllCodes(size)) {
      std::vector<std::uint64_t> ids{0, code.max_id(), code.max_id() / 2};
      for (int i = 0; i < 20; ++i)
        ids.push_back(std::uniform_int_distribution<std::uint64_t>(0, code.max_id())(random));
      for (const std::uint64_t id : ids) {
        const std::uint64_t kernel = code.Encode(id);
        const std::optional<Decoded> decoded = code.DecodeHard(kernel);
        ASSERT_TRUE(decoded.has_value()) << Describe(code) << " id " << id;
        ASSERT_EQ(decoded->id, id) << Describe(code);
        ASSERT_EQ(decoded->kernel, kernel) << Describe(code);
      }
    }
  }
}

TEST(MarkerCode, ConstrainedWordsAreBalancedAndRankedUpwards) {
  const MarkerSize size{4, 7};  // ten kernel cells, five dark
  std::uint64_t previous = 0;
  const MarkerCode saturation(size, Variant::kSaturationConstrained);
  for (std::uint64_t id = 0; id <= saturation.max_id(); ++id) {
    const std::uint64_t kernel = saturation.Encode(id);
    EXPECT_EQ(std::popcount(kernel), 5);
    if (id > 0) {
      EXPECT_GT(kernel, previous);
    }
    previous = kernel;
  }
  const MarkerCode color(size, Variant::kColorConstrained);
  EXPECT_EQ(color.max_id() + 1, 10u * 10u);
  for (std::uint64_t id = 0; id <= color.max_id(); ++id) {
    const std::string colours = CellColours(size, color.Encode(id));
    int blue = 0;
    int yellow = 0;
    for (int index = 0; index < size.rows * size.cols; ++index) {
      if (IsBorder(size, index / size.cols, index % size.cols)) continue;
      blue += colours[static_cast<std::size_t>(index)] == 'B';
      yellow += colours[static_cast<std::size_t>(index)] == 'Y';
    }
    EXPECT_EQ(blue, 2);
    EXPECT_EQ(yellow, 2);
  }
}

}  // namespace
}  // namespace chequer
