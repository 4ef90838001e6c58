#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "chequer/marker.h"
#include "unit/marker/marker_codes.h"

namespace chequer {
namespace {

using test::AllSizes;

/// Border cells of `size` whose colour differs from that of the cell which `source` puts in their place.
int ChangedBorderCells(MarkerSize size, const std::function<Cell(Cell)>& source) {
  const std::string colours = CellColours(size, 0);
  const auto colour = [&](Cell cell) { return colours[static_cast<std::size_t>(cell.row * size.cols + cell.col)]; };
  int changed = 0;
  for (const Cell cell : BorderCells(size)) changed += colour(cell) != colour(source(cell));
  return changed;
}

Cell HalfTurned(MarkerSize size, Cell cell) { return {size.rows - 1 - cell.row, size.cols - 1 - cell.col}; }

TEST(MarkerSize, IsValidUpToSixtyFourKernelCells) {
  EXPECT_TRUE(IsValid({3, 3}));
  EXPECT_TRUE(IsValid({10, 10}));
  EXPECT_TRUE(IsValid({3, 66}));
  EXPECT_TRUE(IsValid({66, 3}));
  EXPECT_FALSE(IsValid({10, 11}));
  EXPECT_FALSE(IsValid({3, 67}));
  EXPECT_FALSE(IsValid({2, 6}));
  EXPECT_FALSE(IsValid({6, 2}));
  EXPECT_FALSE(IsValid({0, 0}));
  EXPECT_FALSE(IsValid({-4, -4}));
  EXPECT_FALSE(IsValid({1 << 30, 1 << 30}));
}

TEST(MarkerSize, ConstantsCoverAllSizes) {
  int corners = 0;
  int cells = 0;
  for (const MarkerSize size : AllSizes()) {
    EXPECT_TRUE(IsValid(size));
    corners = std::max(corners, CornerCount(size));
    cells = std::max(cells, size.rows * size.cols);
  }
  EXPECT_EQ(corners, kMaxCorners);
  EXPECT_EQ(cells, kMaxCells);
}

TEST(MarkerSize, TextGoesThereAndBack) {
  for (const MarkerSize size : AllSizes()) EXPECT_EQ(ParseMarkerSize(ToString(size)), size);
  EXPECT_EQ(ToString({5, 12}), "5x12");
}

TEST(MarkerSize, RefusesWhatIsNotASize) {
  for (const char* text : {"", "x", "6", "6x", "x6", "6x6x6", "6X6", "6 x 6", " 6x6", "6x6 ", "+6x6", "-6x6", "6x-6",
                           "6.0x6", "2x6", "11x11", "99999999999x6", "0x6x6"}) {
    EXPECT_EQ(ParseMarkerSize(text), std::nullopt) << text;
  }
}

TEST(Border, RunsClockwiseOverEveryBorderCellOnce) {
  for (const MarkerSize size : AllSizes()) {
    const std::vector<Cell> cells = BorderCells(size);
    ASSERT_EQ(cells.size(), static_cast<std::size_t>(BorderLength(size)));
    std::map<std::pair<int, int>, int> visits;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const Cell next = cells[(k + 1) % cells.size()];
      EXPECT_TRUE(IsBorder(size, cells[k].row, cells[k].col));
      EXPECT_EQ(std::abs(next.row - cells[k].row) + std::abs(next.col - cells[k].col), 1);
      ++visits[{cells[k].row, cells[k].col}];
    }
    EXPECT_EQ(visits.size(), cells.size());
    EXPECT_EQ(cells.front().row, 0);
    EXPECT_EQ(cells.front().col, 0);
    EXPECT_EQ(cells[1].col, 1) << "not clockwise";
  }
}

TEST(Border, PlainCycleWhereSpecified) {
  for (const MarkerSize size : AllSizes()) {
    if ((size.rows + size.cols) % 4 == 2) continue;
    const std::string colours = CellColours(size, 0);
    const std::vector<Cell> cells = BorderCells(size);
    for (std::size_t k = 0; k < cells.size(); ++k) {
      EXPECT_EQ(colours[static_cast<std::size_t>(cells[k].row * size.cols + cells[k].col)], "KYBW"[k % 4])
          << ToString(size) << " border cell " << k;
    }
  }
}

TEST(Border, SecondHalfIsTheComplementOfTheCycleOnEvenBoards) {
  for (const MarkerSize size : AllSizes()) {
    if ((size.rows + size.cols) % 2 != 0) continue;
    const std::vector<std::uint8_t> saturation = BorderSaturation(size);
    const std::size_t half = saturation.size() / 2;
    for (std::size_t k = 0; k < half; ++k) {
      EXPECT_EQ(saturation[k], (std::array{0, 1, 1, 0}[k % 4]));
      EXPECT_EQ(saturation[k] + saturation[k + half], 1);
    }
  }
}

TEST(Border, PlainCycleWouldSurviveAHalfTurnElsewhere) {
  // Why the complement is there at all: on these sizes the published cycle says nothing about a half turn.
  for (const MarkerSize size : AllSizes()) {
    if ((size.rows + size.cols) % 4 != 2) continue;
    EXPECT_EQ(BorderLength(size) / 2 % 4, 0) << ToString(size);
  }
}

TEST(Border, HalfTurnChangesEveryBorderCell) {
  for (const MarkerSize size : AllSizes()) {
    const int changed = ChangedBorderCells(size, [size](Cell cell) { return HalfTurned(size, cell); });
    EXPECT_EQ(changed, BorderLength(size)) << ToString(size);
  }
}

TEST(Border, HalfTurnSwapsDarkAndLightOnOddBoardsOnly) {
  for (const MarkerSize size : AllSizes()) {
    const Cell turned = HalfTurned(size, {0, 0});
    EXPECT_EQ(IsDark(turned.row, turned.col), (size.rows + size.cols) % 2 == 0) << ToString(size);
  }
}

TEST(Border, QuarterTurnChangesAtLeastHalfOfTheBorderOfASquare) {
  for (int side = 3; side <= 10; ++side) {
    const MarkerSize size{side, side};
    const int changed = ChangedBorderCells(size, [size](Cell cell) {
      return Cell{cell.col, size.rows - 1 - cell.row};
    });
    EXPECT_GE(changed, BorderLength(size) / 2) << ToString(size);
  }
}

TEST(Border, MirrorChangesAtLeastHalfTheBorderButTwo) {
  for (const MarkerSize size : AllSizes()) {
    const int least = BorderLength(size) / 2 - 2;
    const auto across = [size](Cell cell) { return Cell{cell.row, size.cols - 1 - cell.col}; };
    const auto upside_down = [size](Cell cell) { return Cell{size.rows - 1 - cell.row, cell.col}; };
    EXPECT_GE(ChangedBorderCells(size, across), least) << ToString(size);
    EXPECT_GE(ChangedBorderCells(size, upside_down), least) << ToString(size);
    if (size.rows != size.cols) continue;
    const auto diagonal = [](Cell cell) { return Cell{cell.col, cell.row}; };
    const auto other_diagonal = [size](Cell cell) { return Cell{size.cols - 1 - cell.col, size.rows - 1 - cell.row}; };
    EXPECT_GE(ChangedBorderCells(size, diagonal), least) << ToString(size);
    EXPECT_GE(ChangedBorderCells(size, other_diagonal), least) << ToString(size);
  }
}

TEST(Cells, KernelRunsRowByRowMostSignificantFirst) {
  for (const MarkerSize size : AllSizes()) {
    for (int bit = 0; bit < KernelBits(size); ++bit) {
      const int cell = KernelBits(size) - 1 - bit;
      const int index = (1 + cell / (size.cols - 2)) * size.cols + 1 + cell % (size.cols - 2);
      std::vector<std::uint8_t> expected = CellSaturation(size, 0);
      expected[static_cast<std::size_t>(index)] = 1;
      ASSERT_EQ(CellSaturation(size, std::uint64_t{1} << bit), expected) << ToString(size) << " bit " << bit;
    }
  }
}

TEST(Cells, ColoursFollowLuminanceAndSaturation) {
  const std::string colours = CellColours({4, 4}, 0b1001);
  EXPECT_EQ(colours,
            "KYBW"
            "WBWK"
            "BWBY"
            "YKWB"
            "");
}

}  // namespace
}  // namespace chequer
