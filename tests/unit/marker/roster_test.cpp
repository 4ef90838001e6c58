#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "chequer/marker.h"
#include "support/seed.h"
#include "unit/marker/brute_force.h"
#include "unit/marker/marker_codes.h"

namespace chequer {
namespace {

using test::AllCodes;
using test::BruteForce;
using test::Describe;
using test::RandomRatios;

TEST(Roster, SortsAndMakesUnique) {
  const Roster roster({7, 3, 7, ~std::uint64_t{0}, 3});
  EXPECT_THAT(roster.ids(), testing::ElementsAre(3, 7, ~std::uint64_t{0}));
  EXPECT_TRUE(roster.Contains(7));
  EXPECT_TRUE(roster.Contains(~std::uint64_t{0}));
  EXPECT_FALSE(roster.Contains(4));
  EXPECT_FALSE(Roster({}).Contains(0));
}

Roster RandomRoster(std::mt19937_64& random, const MarkerCode& code, std::size_t count) {
  std::vector<std::uint64_t> ids;
  std::uniform_int_distribution<std::uint64_t> any(0, code.max_id());
  for (std::size_t i = 0; i < count; ++i) ids.push_back(any(random));
  return Roster(std::move(ids));
}

TEST(RosterDecoder, IsMaximumLikelihoodAmongTheIdsInUse) {
  std::mt19937_64 random = test::SeededGenerator();
  for (const MarkerSize size : {MarkerSize{3, 3}, {4, 4}, {5, 5}, {6, 6}, {6, 8}, {7, 8}, {8, 8}, {10, 10}}) {
    for (const MarkerCode& code : AllCodes(size)) {
      for (const std::size_t count : {1u, 2u, 50u}) {
        const Roster roster = RandomRoster(random, code, count);
        const BruteForce reference(code, roster);
        const RosterDecoder decoder(code, roster);
        for (int trial = 0; trial < 20; ++trial) {
          const std::vector<float> ratios = RandomRatios(random, KernelBits(size));
          for (const auto& decoded : {decoder.DecodeSoft(ratios), code.DecodeSoft(ratios, &roster)}) {
            ExpectMostLikely(code, reference, ratios, decoded);
            ASSERT_TRUE(roster.Contains(decoded->best.id));
          }
          if (testing::Test::HasFailure()) FAIL() << Describe(code) << " of " << count << " ids, trial " << trial;
        }
      }
    }
  }
}

TEST(RosterDecoder, IdsBeyondTheLastArePassedOver) {
  const MarkerCode code({6, 6}, Variant::kReedMuller);
  const std::vector<float> ratios(16, -1.0f);
  const Roster partly({5, 31, 32, ~std::uint64_t{0}});
  EXPECT_EQ(RosterDecoder(code, partly).DecodeSoft(ratios)->best.id, code.DecodeSoft(ratios, &partly)->best.id);
  EXPECT_LE(code.DecodeSoft(ratios, &partly)->best.id, 31u);
  const Roster beyond({32, 1000});
  EXPECT_FALSE(code.DecodeSoft(ratios, &beyond).has_value());
  EXPECT_FALSE(RosterDecoder(code, beyond).DecodeSoft(ratios).has_value());
}

TEST(RosterDecoder, AnEmptyRosterLeavesNothing) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  const std::vector<float> ratios(16, 1.0f);
  const Roster empty({});
  EXPECT_FALSE(code.DecodeSoft(ratios, &empty).has_value());
  EXPECT_FALSE(RosterDecoder(code, empty).DecodeSoft(ratios).has_value());
}

TEST(RosterDecoder, OneIdHasNoSecond) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  const std::vector<float> ratios(16, 1.0f);
  const SoftDecoded decoded = RosterDecoder(code, Roster({17})).DecodeSoft(ratios).value();
  EXPECT_EQ(decoded.best.id, 17u);
  EXPECT_EQ(decoded.margin, std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace chequer
