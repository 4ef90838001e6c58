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
  std::vector<Hidden> hidden(border.size(), Hidden::kNot);
  std::fill_n(hidden.begin(), occluded_lines * kSixBySix.cols, Hidden::kFlat);
  int agree = 0;
  for (std::uint64_t line = 0; line < 16; ++line)
    agree += AgreesElsewhere(kSixBySix, hidden, CellSaturation(kSixBySix, 0x5020 | line << 8), border);
  return agree;
}

TEST(OtherPlacements, AWholeBoardLiesOneWay) { EXPECT_EQ(AgreeElsewhere(0), 0); }

TEST(OtherPlacements, ABoardWithoutALineLiesOneWay) { EXPECT_EQ(AgreeElsewhere(1), 0); }

TEST(OtherPlacements, OneBoardInSixteenWithoutTwoLinesMayLieTwoWays) { EXPECT_EQ(AgreeElsewhere(2), 1); }

TEST(OtherPlacements, ABoardWhoseColoursCannotBeToldMayLieAnyWay) {
  const std::vector<std::uint8_t> border = CellSaturation(kSixBySix, 0), untold(border.size(), kInkUntold);
  std::vector<Hidden> hidden(border.size(), Hidden::kNot);
  EXPECT_TRUE(AgreesElsewhere(kSixBySix, hidden, untold, border));
  std::fill_n(hidden.begin(), 3 * kSixBySix.cols, Hidden::kFlat);
  EXPECT_TRUE(AgreesElsewhere(kSixBySix, hidden, untold, border));
}

}  // namespace
}  // namespace chequer
