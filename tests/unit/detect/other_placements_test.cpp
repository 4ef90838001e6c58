#include <gtest/gtest.h>

#include <vector>

#include "detect/identity/marker_description.h"

namespace chequer {
namespace {

constexpr MarkerSize kSixBySix{6, 6};

/// How many of the 16 boards whose third line has each pattern agree with the border elsewhere too, of which so many
/// lines at the top are occluded.
int AgreeElsewhere(int occluded_lines) {
  const std::vector<std::uint8_t> border = CellSaturation(kSixBySix, 0);
  std::vector<std::uint8_t> occluded(border.size(), 0);
  std::fill_n(occluded.begin(), occluded_lines * kSixBySix.cols, std::uint8_t{1});
  int agree = 0;
  for (std::uint64_t line = 0; line < 16; ++line)
    agree += AgreesElsewhere(kSixBySix, occluded, CellSaturation(kSixBySix, 0x5020 | line << 8), border);
  return agree;
}

TEST(OtherPlacements, AWholeBoardLiesOneWay) { EXPECT_EQ(AgreeElsewhere(0), 0); }

TEST(OtherPlacements, ABoardWithoutALineLiesOneWay) { EXPECT_EQ(AgreeElsewhere(1), 0); }

TEST(OtherPlacements, OneBoardInSixteenWithoutTwoLinesMayLieTwoWays) { EXPECT_EQ(AgreeElsewhere(2), 1); }

}  // namespace
}  // namespace chequer
