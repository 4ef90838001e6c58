#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "chequer/marker.h"

namespace chequer {

/// The border's saturation at one size, precomputed.
struct BorderPattern {
  explicit BorderPattern(MarkerSize marker_size);
  MarkerSize size;
  std::vector<Cell> cells;
  std::vector<std::uint8_t> saturated;
  /// The light cells and their saturation, by turn, in rows and columns of the footprint.
  std::array<std::vector<std::pair<Cell, std::uint8_t>>, 4> light_cells;
  /// For each cell of the board, row by row, its place in the footprint, row by row as well; by turn.
  std::array<std::vector<std::size_t>, 4> in_footprint;
};

/// Cell (row, col) of the board in the footprint's own rows and columns, for a board turned by quarter turns.
Cell InFootprint(MarkerSize size, int row, int col, int turn);

}  // namespace chequer
