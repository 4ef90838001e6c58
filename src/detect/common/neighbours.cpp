#include "detect/common/neighbours.h"

#include <algorithm>
#include <cstddef>

namespace chequer {
namespace {

/// Occludes cells until follows(left, right, up, down), whether those beside it are occluded, is true of no other.
template <class Follows>
void Spread(MarkerSize size, std::span<std::uint8_t> occluded, const Follows& follows) {
  const auto is_occluded = [&](int row, int col) {
    return row >= 0 && col >= 0 && row < size.rows && col < size.cols &&
           occluded[static_cast<std::size_t>(row * size.cols + col)] != 0;
  };
  // Fewer than two have nothing between them.
  bool changed = std::count(occluded.begin(), occluded.end(), 0) + 2 <= static_cast<std::ptrdiff_t>(occluded.size());
  while (changed) {
    changed = false;
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        std::uint8_t& cell = occluded[static_cast<std::size_t>(row * size.cols + col)];
        if (cell || !follows(is_occluded(row, col - 1), is_occluded(row, col + 1), is_occluded(row - 1, col),
                             is_occluded(row + 1, col)))
          continue;
        cell = 1;
        changed = true;
      }
  }
}

}  // namespace

std::span<const float> NeighbourLead::Of(int rows, int cols, std::span<const float> values,
                                         std::span<const std::uint8_t> counts) {
  const std::size_t width = static_cast<std::size_t>(cols), height = static_cast<std::size_t>(rows), stride = width + 2;
  value_.assign(stride * (height + 2), 0.0f);
  count_.assign(value_.size(), 0.0f);
  for (std::size_t row = 0, i = 0; row < height; ++row)
    for (std::size_t col = 0, at = (row + 1) * stride + 1; col < width; ++col, ++i, ++at) {
      count_[at] = counts[i] ? 1.0f : 0.0f;
      value_[at] = count_[at] * values[i];
    }
  lead_.resize(values.size());
  for (std::size_t row = 0, i = 0; row < height; ++row)
    for (std::size_t col = 0, at = (row + 1) * stride + 1; col < width; ++col, ++i, ++at) {
      const float sum = value_[at - 1] + value_[at + 1] + value_[at - stride] + value_[at + stride];
      const float count = count_[at - 1] + count_[at + 1] + count_[at - stride] + count_[at + stride];
      lead_[i] = count > 0 ? values[i] - sum / std::max(count, 1.0f) : 0.0f;
    }
  return lead_;
}

void HideEnclosed(MarkerSize size, std::span<std::uint8_t> occluded) {
  Spread(size, occluded, [](int left, int right, int up, int down) { return left + right + up + down >= 2; });
}

void HideBetween(MarkerSize size, std::span<std::uint8_t> occluded) {
  Spread(size, occluded, [](bool left, bool right, bool up, bool down) { return (left && right) || (up && down); });
}

}  // namespace chequer
