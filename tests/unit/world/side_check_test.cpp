#include "world/side_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

WorldCalibration WorldOf(double side_m) {
  WorldCalibration world;
  WorldReference reference;
  reference.id = 12;
  reference.side_m = side_m;
  world.references.push_back(reference);
  return world;
}

MarkerFamily Family(double side_m, std::vector<std::uint64_t> roster = {}) {
  return {.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = side_m, .roster = std::move(roster)};
}

std::string Contradiction(double side_m, const std::vector<MarkerFamily>& families) {
  return SideContradiction(WorldOf(side_m), families);
}

TEST(SideContradiction, NamesBothSides) {
  EXPECT_THAT(Contradiction(0.12, {Family(0.10)}),
              AllOf(HasSubstr("100 mm here"), HasSubstr("120 mm in the world file"), HasSubstr("reference 12")));
}

TEST(SideContradiction, LetsTwoRulersDiffer) {
  EXPECT_EQ(Contradiction(0.12, {Family(0.1195)}), "");
  EXPECT_NE(Contradiction(0.12, {Family(0.117)}), "");
}

TEST(SideContradiction, PassesOverFamiliesThatDoNotBearTheReference) {
  EXPECT_EQ(Contradiction(0.12, {Family(0.10, {1, 2, 3})}), "");
  EXPECT_EQ(Contradiction(0.12, {{.code = MarkerCode({6, 6}, Variant::kUnconstrained), .side_m = 0.1, .roster = {}}}),
            "");
  EXPECT_EQ(Contradiction(0.12, {Family(0.10), Family(0.12)}), "");
}

}  // namespace
}  // namespace chequer
