#include "detect/identity/other_placements.h"

#include <algorithm>

namespace chequer {
namespace {

/// A placement on a board of n rows and n or other columns: turns by 90°, then a shift.
struct OtherPlacement {
  int turns, down, right;

  Cell Of(MarkerSize size, int row, int col) const {
    int rows = size.rows, cols = size.cols;
    for (int turn = 0; turn < turns; ++turn) {
      const int turned = rows - 1 - row;
      row = col;
      col = turned;
      std::swap(rows, cols);
    }
    return {row + down, col + right};
  }
};

bool Agrees(MarkerSize size, const OtherPlacement& placement, std::span<const std::uint8_t> occluded,
            std::span<const std::uint8_t> saturated, std::span<const std::uint8_t> border) {
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const std::size_t from = static_cast<std::size_t>(row * size.cols + col);
      if (occluded[from]) continue;
      const Cell to = placement.Of(size, row, col);
      if (to.row < 0 || to.col < 0 || to.row >= size.rows || to.col >= size.cols) return false;
      if (IsDark(row, col) != IsDark(to.row, to.col)) return false;
      const std::size_t at = static_cast<std::size_t>(to.row * size.cols + to.col);
      if (IsBorder(size, to.row, to.col) && saturated[from] != border[at]) return false;
    }
  return true;
}

}  // namespace

bool AgreesElsewhere(MarkerSize size, std::span<const std::uint8_t> occluded, std::span<const std::uint8_t> saturated,
                     std::span<const std::uint8_t> border) {
  const int most = std::max(size.rows, size.cols) - 1;
  for (int turns = 0; turns < 4; ++turns)
    for (int down = -most; down <= most; ++down)
      for (int right = -most; right <= most; ++right) {
        if (turns == 0 && down == 0 && right == 0) continue;
        if (Agrees(size, {turns, down, right}, occluded, saturated, border)) return true;
      }
  return false;
}

}  // namespace chequer
