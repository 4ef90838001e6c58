#include "detect/common/neighbours.h"

#include <gtest/gtest.h>

#include <array>

namespace chequer {
namespace {

TEST(NeighbourLead, ComparesWithTheNeighboursThatCount) {
  // 2 × 3 cells.
  const std::array<float, 6> values{10, 2, 30, 4, 50, 7};
  const std::array<std::uint8_t, 6> all{1, 1, 1, 1, 1, 1};
  NeighbourLead lead;
  const auto of_all = lead.Of(2, 3, values, all);
  ASSERT_EQ(of_all.size(), 6u);
  EXPECT_FLOAT_EQ(of_all[0], 10 - (2 + 4) / 2.0f);
  EXPECT_FLOAT_EQ(of_all[1], 2 - (10 + 30 + 50) / 3.0f);
  EXPECT_FLOAT_EQ(of_all[5], 7 - (30 + 50) / 2.0f);
  // A cell that does not count itself still has its lead.
  const std::array<std::uint8_t, 6> some{1, 0, 1, 1, 0, 0};
  const auto of_some = lead.Of(2, 3, values, some);
  EXPECT_FLOAT_EQ(of_some[0], 10 - 4);
  EXPECT_FLOAT_EQ(of_some[1], 2 - (10 + 30) / 2.0f);
}

TEST(NeighbourLead, IsZeroWithoutNeighbours) {
  const std::array<float, 4> values{10, 2, 30, 4};
  const std::array<std::uint8_t, 4> one{1, 0, 0, 0};
  NeighbourLead lead;
  const auto found = lead.Of(2, 2, values, one);
  EXPECT_EQ(found[0], 0);
  EXPECT_EQ(found[3], 0);
  EXPECT_FLOAT_EQ(found[1], 2 - 10);
}

TEST(HideBetween, HidesCellsThatLieBetweenOccludedOnes) {
  std::array<std::uint8_t, 12> occluded{1, 0, 1, 0,  //
                                        0, 0, 0, 0,  //
                                        1, 0, 1, 0};
  HideBetween({3, 4}, occluded);
  const std::array<std::uint8_t, 12> expected{1, 1, 1, 0,  //
                                              1, 1, 1, 0,  //
                                              1, 1, 1, 0};
  EXPECT_EQ(occluded, expected);
}

TEST(HideBetween, TakesNoLineAlongForOneCellOfItAsHideEnclosedDoes) {
  // Beside a hidden line, every cell had two hidden neighbours once one of the next line was hidden.
  std::array<std::uint8_t, 12> occluded{0, 0, 0, 1,  //
                                        0, 0, 1, 1,  //
                                        0, 0, 0, 1};
  const std::array<std::uint8_t, 12> before = occluded;
  HideBetween({3, 4}, occluded);
  EXPECT_EQ(occluded, before);
  HideEnclosed({3, 4}, occluded);
  const std::array<std::uint8_t, 12> expected{0, 0, 1, 1,  //
                                              0, 0, 1, 1,  //
                                              0, 0, 1, 1};
  EXPECT_EQ(occluded, expected);
}

}  // namespace
}  // namespace chequer
