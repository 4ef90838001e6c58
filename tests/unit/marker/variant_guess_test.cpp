#include "marker/variant_guess.h"

#include <gtest/gtest.h>

#include <random>

#include "marker/variants.h"

namespace chequer {
namespace {

constexpr MarkerSize kSize{6, 6};

std::optional<Variant> Guess(Variant sought, Variant printed, std::uint64_t first, std::uint64_t count) {
  const MarkerCode code(kSize, printed);
  VariantGuess guess{MarkerCode(kSize, sought)};
  for (std::uint64_t id = first; id < first + count && id <= code.max_id(); ++id) guess.Add(code.Encode(id));
  return guess.LooksLike();
}

std::vector<Variant> Variants() {
  std::vector<Variant> exist;
  for (const auto& [name, variant] : kVariants) {
    if (variant == Variant::kTable) continue;
    try {
      MarkerCode(kSize, variant);
      exist.push_back(variant);
    } catch (const std::runtime_error&) {
    }
  }
  return exist;
}

TEST(VariantGuess, AHandfulOfBoardsDecides) {
  EXPECT_EQ(Guess(Variant::kUnconstrained, Variant::kSecded, 1000, 5), Variant::kSecded);
  EXPECT_EQ(Guess(Variant::kReedMuller, Variant::kSecded, 1000, 5), Variant::kSecded);
  EXPECT_EQ(Guess(Variant::kSecded, Variant::kReedMuller, 5, 5), Variant::kReedMuller);
  EXPECT_EQ(Guess(Variant::kUnconstrained, Variant::kReedMuller, 3, 5), Variant::kReedMuller);
}

TEST(VariantGuess, VariantsThatReadTheSameIdsAreNoMatter) {
  // The first 32 ids of nordstrom_robinson are those of reed_muller.
  EXPECT_FALSE(Guess(Variant::kNordstromRobinson, Variant::kReedMuller, 0, 32));
  EXPECT_TRUE(Guess(Variant::kReedMuller, Variant::kNordstromRobinson, 100, 5));
}

TEST(VariantGuess, OneBoardDecidesNothing) {
  for (const Variant sought : Variants())
    for (std::uint64_t id = 0; id < 30; ++id)
      EXPECT_FALSE(Guess(sought, sought, id, 1)) << VariantName(sought) << " " << id;
}

// The smallest ids are printed most: they must not look like another variant's.
TEST(VariantGuess, TheRightVariantIsNeverDoubted) {
  for (const Variant variant : Variants())
    for (const std::uint64_t count : {2u, 3u, 5u, 10u, 50u, 200u}) {
      const auto doubt = Guess(variant, variant, 0, count);
      EXPECT_FALSE(doubt) << VariantName(variant) << " of " << count << " ids looks like "
                          << (doubt ? VariantName(*doubt) : "");
    }
}

TEST(VariantGuess, MisreadCellsRaiseNoDoubt) {
  std::mt19937 random(7);
  for (const Variant variant : {Variant::kSecded, Variant::kReedMuller, Variant::kUnconstrained}) {
    const MarkerCode code(kSize, variant);
    VariantGuess guess{code};
    for (int i = 0; i < 40; ++i) {
      std::uint64_t kernel = code.Encode(random() % (code.max_id() + 1));
      if (i % 5 == 0) kernel ^= 1u << (random() % 16);
      guess.Add(kernel);
    }
    EXPECT_FALSE(guess.LooksLike()) << VariantName(variant);
  }
}

TEST(VariantGuess, TheSameBoardAgainSaysNothingNew) {
  VariantGuess guess{MarkerCode(kSize, Variant::kUnconstrained)};
  for (int i = 0; i < 1000; ++i) guess.Add(MarkerCode(kSize, Variant::kSecded).Encode(77));
  EXPECT_EQ(guess.count(), 1u);
  EXPECT_FALSE(guess.LooksLike());
}

}  // namespace
}  // namespace chequer
