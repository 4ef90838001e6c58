#include "detect/boards/border_pattern.h"

namespace chequer {

Cell InFootprint(MarkerSize size, int row, int col, int turn) {
  switch (turn) {
    case 0: return {row, col};
    case 1: return {col, size.rows - 1 - row};  // the board's columns run down
    case 2: return {size.rows - 1 - row, size.cols - 1 - col};
    default: return {size.cols - 1 - col, row};
  }
}

BorderPattern::BorderPattern(MarkerSize marker_size)
    : size(marker_size), cells(BorderCells(marker_size)), saturated(BorderSaturation(marker_size)) {
  for (int turn = 0; turn < 4; ++turn) {
    const int footprint_cols = turn % 2 == 0 ? size.cols : size.rows;
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        const Cell cell = InFootprint(size, row, col, turn);
        in_footprint[static_cast<std::size_t>(turn)].push_back(
            static_cast<std::size_t>(cell.row * footprint_cols + cell.col));
      }
    for (std::size_t k = 0; k < cells.size(); ++k)
      if (!IsDark(cells[k].row, cells[k].col))
        light_cells[static_cast<std::size_t>(turn)].emplace_back(InFootprint(size, cells[k].row, cells[k].col, turn),
                                                                 saturated[k]);
  }
}

}  // namespace chequer
