#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "chequer/marker.h"

namespace chequer {

/// How much larger each cell's value is than the mean of its up to four neighbours, row by row.
class NeighbourLead {
 public:
  /// @param values, counts one a cell, row by row; only neighbours that count are looked at. Returns 0 for a cell
  /// without any. The result lasts until the next call.
  std::span<const float> Of(int rows, int cols, std::span<const float> values, std::span<const std::uint8_t> counts);

 private:
  /// With a rim of cells that do not count, so that nothing branches on where a cell lies.
  std::vector<float> value_, count_;
  std::vector<float> lead_;
};

/// What lies over a board hides cells side by side: a cell between occluded ones that looks like one of the board is a
/// part of the cover that happens to. Hides every cell of which two neighbours are occluded, until there is none.
/// @param occluded by cell, row by row.
void HideEnclosed(MarkerSize size, std::span<std::uint8_t> occluded);
/// The same of cells whose neighbours on two opposite sides are, for cells that were read: beside a hidden line, a
/// single one would take all of the next line along. (Measured: 1 % more ids of streams of covered boards, and as many
/// wrong ones.)
void HideBetween(MarkerSize size, std::span<std::uint8_t> occluded);

}  // namespace chequer
