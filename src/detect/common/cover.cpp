#include "detect/common/cover.h"

#include <algorithm>
#include <cstddef>

namespace chequer {

void HideBetween(MarkerSize size, std::span<std::uint8_t> hidden) {
  const auto is_hidden = [&](int row, int col) -> int {
    return row >= 0 && col >= 0 && row < size.rows && col < size.cols &&
           hidden[static_cast<std::size_t>(row * size.cols + col)];
  };
  // Fewer than two have nothing between them.
  bool changed = std::count(hidden.begin(), hidden.end(), 0) + 2 <= static_cast<std::ptrdiff_t>(hidden.size());
  while (changed) {
    changed = false;
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        std::uint8_t& cell = hidden[static_cast<std::size_t>(row * size.cols + col)];
        if (cell ||
            is_hidden(row - 1, col) + is_hidden(row + 1, col) + is_hidden(row, col - 1) + is_hidden(row, col + 1) < 2)
          continue;
        cell = 1;
        changed = true;
      }
  }
}

}  // namespace chequer
