// What shows of a board, cell by cell and corner by corner, and why the rest does not.
#include "detect/common/visibility.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "simulate/render.h"
#include "support/stress_frames.h"

namespace chequer {
namespace {

using ::testing::Each;

constexpr MarkerSize kSize{6, 6};

std::size_t CellAt(int row, int col) { return static_cast<std::size_t>(row * kSize.cols + col); }

TEST(Visibility, BeginsWithAllOfABoard) {
  const Visibility visibility(kSize);
  EXPECT_THAT(visibility.cells(), Each(Hidden::kNot));
  EXPECT_EQ(visibility.cells().size(), 36u);
  EXPECT_EQ(visibility.CountCorners(), 25);
  EXPECT_TRUE(visibility.ShowsAll());
  EXPECT_TRUE(visibility.ShowsAllCorners());
}

TEST(Visibility, KeepsTheFirstReasonOfACell) {
  Visibility visibility(kSize);
  visibility.Hide(3, Hidden::kOutside);
  visibility.Hide(3, Hidden::kFlat);
  EXPECT_EQ(visibility.cells()[3], Hidden::kOutside);
  EXPECT_EQ(visibility.hidden_cells(), 1);
}

TEST(Visibility, HidesWhatHiddenCellsEnclose) {
  Visibility visibility(kSize);
  visibility.Hide(CellAt(2, 1), Hidden::kFlat);
  visibility.Hide(CellAt(2, 3), Hidden::kFlat);
  visibility.HideEnclosed();
  EXPECT_EQ(visibility.cells()[CellAt(2, 2)], Hidden::kEnclosed);
  EXPECT_EQ(visibility.hidden_cells(), 3);
}

TEST(Visibility, LeavesCornersOfHiddenCells) {
  Visibility visibility(kSize);
  visibility.Hide(CellAt(0, 0), Hidden::kFlat);
  EXPECT_TRUE(visibility.LiesBesideHidden(0));
  EXPECT_FALSE(visibility.LiesBesideHidden(1));
  visibility.Hide(CellAt(0, 1), Hidden::kFlat);
  EXPECT_TRUE(visibility.LiesBesideHidden(1));
  EXPECT_FALSE(visibility.LiesBesideHidden(2));
}

TEST(Visibility, CellsFollowTheCornersAroundThem) {
  Visibility visibility(kSize);
  // A cell that seemed flat before its corners were looked at, beside all others.
  visibility.Hide(CellAt(4, 4), Hidden::kFlat);
  visibility.Set(0, Hidden::kMisfit);
  visibility.Set(1, Hidden::kMisfit);
  Visibility by_any = visibility;
  EXPECT_TRUE(visibility.ShowCellsByAllCorners());
  EXPECT_FALSE(visibility.ShowCellsByAllCorners()) << "once more changes nothing";
  for (const std::size_t beside : {CellAt(0, 0), CellAt(0, 1), CellAt(1, 1), CellAt(0, 2), CellAt(1, 2)})
    EXPECT_EQ(visibility.cells()[beside], Hidden::kBeside) << beside;
  EXPECT_EQ(visibility.hidden_cells(), 6) << "the cell that seemed flat has four corners that show";
  by_any.ShowCellsByAnyCorner();
  EXPECT_EQ(by_any.cells()[CellAt(0, 0)], Hidden::kBeside);
  EXPECT_EQ(by_any.cells()[CellAt(0, 1)], Hidden::kBeside);
  EXPECT_EQ(by_any.hidden_cells(), 2) << "the others have another corner";
  by_any.Set(0, Hidden::kNot);
  by_any.Set(1, Hidden::kNot);
  by_any.ShowCellsByAnyCorner();
  EXPECT_TRUE(by_any.ShowsAll());
}

TEST(Visibility, ShowsAroundACellWhatLiesBesideIt) {
  Visibility visibility(kSize);
  EXPECT_TRUE(visibility.ShowsAround(0, 0));
  visibility.Hide(CellAt(2, 3), Hidden::kFlat);
  for (const auto& [row, col] : {std::pair(1, 3), std::pair(3, 3), std::pair(2, 2), std::pair(2, 4)})
    EXPECT_FALSE(visibility.ShowsAround(row, col)) << row << ", " << col;
  EXPECT_TRUE(visibility.ShowsAround(1, 2)) << "beside a corner of it alone";
  visibility.Set(0, Hidden::kMisfit);
  for (const auto& [row, col] : {std::pair(0, 0), std::pair(0, 1), std::pair(1, 0), std::pair(1, 1)})
    EXPECT_FALSE(visibility.ShowsAround(row, col)) << row << ", " << col;
  EXPECT_TRUE(visibility.ShowsAround(0, 2));
  EXPECT_TRUE(visibility.ShowsAround(5, 5)) << "at the rim";
}

TEST(Visibility, TakesCellsAlone) {
  Visibility earlier(kSize), visibility(kSize);
  earlier.Hide(7, Hidden::kBeside);
  earlier.Set(3, Hidden::kMisfit);
  visibility.Set(9, Hidden::kPulled);
  visibility.TakeCellsOf(earlier);
  EXPECT_EQ(visibility.cells()[7], Hidden::kBeside);
  EXPECT_TRUE(visibility.ShowsCorner(3));
  EXPECT_EQ(visibility.OfCorner(9), Hidden::kPulled);
}

TEST(Visibility, EveryReasonHasANameOfItsOwn) {
  for (int a = 0; a < kReasonsToHide; ++a)
    for (int b = 0; b < a; ++b)
      EXPECT_NE(HiddenName(static_cast<Hidden>(a)), HiddenName(static_cast<Hidden>(b))) << a << ", " << b;
}

// The whole way: something dull over two columns of a board.
TEST(Visibility, OfABoardSaysWhyPartsOfItAreNotUsed) {
  const StressCase stress = test::CaseOf("occluded=0.2", MarkerCode(kSize, Variant::kSecded), 3);
  const Image image = Render(stress.scene, stress.options, 3);
  DetectTrace trace;
  std::vector<MarkerPose> markers;
  Detector(DetectorOptions{}).Detect(image.view(), markers, &trace);
  ASSERT_EQ(markers.size(), 1u);
  const auto candidate = std::find_if(trace.candidates.begin(), trace.candidates.end(),
                                      [](const TraceCandidate& of) { return of.marker == 0; });
  ASSERT_NE(candidate, trace.candidates.end());
  ASSERT_EQ(candidate->inner_corners.size(), 25u);
  int used = 0, hidden_cells = 0;
  for (const Hidden why : candidate->inner_corners) used += why == Hidden::kNot;
  EXPECT_EQ(used, markers[0].corners_used);
  for (const TraceCell& cell : candidate->cells) {
    EXPECT_EQ(cell.seen, cell.hidden == Hidden::kNot) << cell.at.row << ", " << cell.at.col;
    hidden_cells += !cell.seen;
  }
  EXPECT_GE(hidden_cells, 6);
  EXPECT_LE(hidden_cells, 18);
}

}  // namespace
}  // namespace chequer
