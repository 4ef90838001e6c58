#include "detect/common/cover.h"

#include <algorithm>
#include <cstddef>

namespace chequer {

void HideBetween(MarkerSize size, std::span<std::uint8_t> occluded) {
  const auto is_occluded = [&](int row, int col) -> int {
    return row >= 0 && col >= 0 && row < size.rows && col < size.cols &&
           occluded[static_cast<std::size_t>(row * size.cols + col)];
  };
  // Fewer than two have nothing between them.
  bool changed = std::count(occluded.begin(), occluded.end(), 0) + 2 <= static_cast<std::ptrdiff_t>(occluded.size());
  while (changed) {
    changed = false;
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        std::uint8_t& cell = occluded[static_cast<std::size_t>(row * size.cols + col)];
        if (cell || is_occluded(row - 1, col) + is_occluded(row + 1, col) + is_occluded(row, col - 1) +
                            is_occluded(row, col + 1) <
                        2)
          continue;
        cell = 1;
        changed = true;
      }
  }
}

}  // namespace chequer
