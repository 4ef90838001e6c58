// What cells may be that a cover lies over in part.
#include "detect/identity/cover_mix.h"

#include <gtest/gtest.h>

#include <vector>

#include "chequer/marker.h"

namespace chequer {
namespace {

constexpr MarkerSize kMixedSize{6, 6};
const Eigen::Vector3f kWhite(0.8f, 0.8f, 0.75f), kYellow(0.7f, 0.6f, 0.05f), kBlack(0.08f, 0.08f, 0.08f),
    kBlue(0.08f, 0.09f, 0.36f), kBrown(0.5f, 0.38f, 0.2f);

/// A board whose last column a brown cover hides.
struct HalfCovered {
  std::vector<std::uint8_t> border = CellSaturation(kMixedSize, 0);
  CellLights lights;
  Visibility visibility{kMixedSize};

  HalfCovered() {
    lights.light.resize(border.size());
    ForCells(kMixedSize, [&](std::size_t cell, int row, int col) {
      const bool inked = border[cell] != 0;
      lights.light[cell] = IsDark(row, col) ? (inked ? kBlue : kBlack) : (inked ? kYellow : kWhite);
      if (col < 5) return;
      lights.light[cell] = kBrown;
      visibility.Hide(cell, Hidden::kFlat);
    });
  }

  /// The lead of a dark cell of that light, which lies beside the cover.
  double LeadOfDark(const Eigen::Vector3f& light, double lead) {
    lights.light[2 * 6 + 4] = light;
    return CoverMix({kMixedSize, border, lights, visibility}, kWhite).LeastLead(2, 4, lead);
  }
};

TEST(CoverMix, KeepsWhatAnInkShows) {
  HalfCovered board;
  ASSERT_TRUE(IsDark(2, 4));
  // Neither is a mix of the other one with brown.
  EXPECT_LT(board.LeadOfDark(kBlack, -0.5), -0.3);
  EXPECT_GT(board.LeadOfDark(kBlue, 0.5), 0.3);
}

TEST(CoverMix, TellsNothingOfACellThatMayBeAMix) {
  // Blue is the complement of brown: the mix is as colourless as black.
  HalfCovered board;
  EXPECT_EQ(board.LeadOfDark(0.55f * kBlue + 0.45f * kBrown, -0.13), 0);
  // Half a black cell still reads as black.
  EXPECT_LT(board.LeadOfDark(0.55f * kBlack + 0.45f * kBrown, -0.5), -0.1);
}

TEST(CoverMix, AsksHiddenCellsOfTheRowAndColumnAlone) {
  HalfCovered board;
  for (std::size_t cell = 5; cell < 36; cell += 6) board.lights.light[cell] = kBlack;
  board.visibility = Visibility(kMixedSize);
  board.visibility.Hide(5, Hidden::kFlat);
  EXPECT_EQ(board.LeadOfDark(kBlack, -0.5), -0.5) << "a black cover in another row and column";
  board.visibility.Hide(2 * 6 + 5, Hidden::kFlat);
  EXPECT_NEAR(board.LeadOfDark(kBlack, -0.5), -0.125, 1e-3) << "a black cover of up to half a blue cell";
}

TEST(CoverMix, KeepsTheLeadWithoutInksThatDiffer) {
  HalfCovered alike;
  ForCells(kMixedSize, [&](std::size_t cell, int row, int col) {
    if (IsDark(row, col) && col < 5) alike.lights.light[cell] = kBlack;
  });
  EXPECT_EQ(alike.LeadOfDark(kBlack, -0.5), -0.5);
  HalfCovered board;
  for (std::size_t cell = 0; cell < 36; ++cell) board.visibility.Hide(cell, Hidden::kFlat);
  EXPECT_EQ(board.LeadOfDark(kBlack, -0.5), -0.5);
}

}  // namespace
}  // namespace chequer
