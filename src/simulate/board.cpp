#include "simulate/board.h"

#include <algorithm>

#include "chequer/check.h"

namespace chequer {

double Board::CellSize(double side_m) const { return side_m / (std::max(rows, cols) - 2 * uncounted_rim); }

bool Board::Alternates() const {
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      const char cell = cells[static_cast<std::size_t>(row * cols + col)];
      if (IsDark(row, col) != (cell == 'K' || cell == 'B')) return false;
    }
  return true;
}

Board MakeBoard(const MarkerCode& code, std::uint64_t id) {
  CHEQUER_CHECK(id <= code.max_id(), "the id is beyond the variant's largest");
  Board board;
  board.rows = code.size().rows;
  board.cols = code.size().cols;
  board.cells = CellColours(code.size(), code.Encode(id));
  board.id = id;
  board.variant = VariantName(code.variant());
  return board;
}

}  // namespace chequer
