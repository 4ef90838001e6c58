// Which ink the cells of a board have, by their light.
#include "detect/identity/cell_inks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "chequer/marker.h"

namespace chequer {
namespace {

constexpr MarkerSize kInkedSize{6, 6};

std::size_t InkedCell(int row, int col) { return static_cast<std::size_t>(row * kInkedSize.cols + col); }

/// A board whose cells have the border's inks, on white paper that reflects as much light as this.
struct InkedBoard {
  std::vector<std::uint8_t> border = CellSaturation(kInkedSize, 0);
  CellLights lights;
  Visibility visibility{kInkedSize};

  explicit InkedBoard(float white) {
    lights.light.resize(border.size());
    lights.half_lit.assign(border.size(), 1);
    lights.overexposed.assign(border.size(), 0);
    ForCells(kInkedSize, [&](std::size_t cell, int row, int col) {
      const bool inked = border[cell] != 0;
      lights.light[cell] = white * (IsDark(row, col) ? Eigen::Vector3f(0.15f, 0.15f, inked ? 0.4f : 0.15f)
                                                     : Eigen::Vector3f(0.9f, 0.85f, inked ? 0.25f : 0.85f));
    });
  }

  /// A lamp's image lies over that cell, and 0.7 times as bright over those beside it.
  void AddLamp(int row, int col, float light) {
    ForCells(kInkedSize, [&](std::size_t cell, int at_row, int at_col) {
      const int off = std::abs(at_row - row) + std::abs(at_col - col);
      if (off <= 1) lights.light[cell].array() += off == 0 ? light : 0.7f * light;
    });
  }

  /// The sensor ends at 1.
  void Expose() {
    for (std::size_t cell = 0; cell < lights.light.size(); ++cell) {
      lights.overexposed[cell] = lights.light[cell].maxCoeff() >= 1;
      lights.light[cell] = lights.light[cell].cwiseMin(1);
    }
  }

  std::optional<double> LeadOf(int row, int col) const {
    CellInks inks(ColorSpace::kLab);
    inks.Start();
    const bool dark = IsDark(row, col);
    if (!inks.Measure({kInkedSize, border, lights, visibility}) || !inks.Of(dark).usable) return std::nullopt;
    return inks.LeadOf(InkedCell(row, col), dark, 1);
  }
};

class CellInksUnderLamps : public testing::TestWithParam<bool> {
 protected:
  /// A light cell of the kernel.
  static constexpr int kRow = 2, kCol = 3;

  /// Of a board whose kernel cell is yellow or white.
  static InkedBoard WithCell(bool yellow, float white) {
    InkedBoard board(white);
    board.lights.light[InkedCell(kRow, kCol)][2] = white * (yellow ? 0.25f : 0.85f);
    return board;
  }
};

TEST_P(CellInksUnderLamps, TellInksWhereNothingIsOverexposed) {
  InkedBoard board = WithCell(GetParam(), 0.6f);
  board.AddLamp(kRow, kCol, 0.3f);
  board.Expose();
  const auto lead = board.LeadOf(kRow, kCol);
  ASSERT_TRUE(lead);
  EXPECT_GT(GetParam() ? *lead : -*lead, 0.2);
}

TEST_P(CellInksUnderLamps, TellNothingWrongWhereTheyAre) {
  for (const float lamp : {0.4f, 0.6f, 0.8f, 1.2f}) {
    InkedBoard board = WithCell(GetParam(), 1.05f);
    board.AddLamp(kRow, kCol, lamp);
    board.Expose();
    const auto lead = board.LeadOf(kRow, kCol);
    ASSERT_TRUE(lead);
    EXPECT_GE(GetParam() ? *lead : -*lead, 0) << "light of the lamp's image " << lamp;
  }
}

TEST_P(CellInksUnderLamps, TellOverexposedCellsBesideNoLamp) {
  InkedBoard board = WithCell(GetParam(), 1.3f);
  board.Expose();
  const auto lead = board.LeadOf(kRow, kCol);
  ASSERT_TRUE(lead);
  EXPECT_GT(GetParam() ? *lead : -*lead, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Both, CellInksUnderLamps, testing::Bool(),
                         [](const auto& info) { return info.param ? "Yellow" : "White"; });

}  // namespace
}  // namespace chequer
