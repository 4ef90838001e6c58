#include "simulate/board_rectangles.h"

#include <algorithm>
#include <cmath>

#include "simulate/random.h"
#include "simulate/separations.h"

namespace chequer {
namespace {

Eigen::Array4f Opaque(const Eigen::Vector3f& colour) { return {colour.x(), colour.y(), colour.z(), 1}; }

/// The part of a light cell that the spread of its dark neighbours leaves.
Rectangle LightCell(const SceneMarker& marker, int row, int col) {
  const Board& board = marker.board;
  const double spread = marker.ink_spread_cells;
  return {col + (col > 0 ? spread : 0),
          row + (row > 0 ? spread : 0),
          col + 1 - (col < board.cols - 1 ? spread : 0),
          row + 1 - (row < board.rows - 1 ? spread : 0),
          {}};
}

/// Dark cells grown over the light ones. Diagonal neighbours then overlap in a square at their common corner; half of
/// each is taken away again, so that the sum stays exact.
void AddSpread(const SceneMarker& marker, std::vector<Rectangle>& rectangles) {
  const Board& board = marker.board;
  const double e = marker.ink_spread_cells;
  const auto ink = [&](int row, int col) {
    return Opaque(marker.inks.Of(board.cells[static_cast<std::size_t>(row * board.cols + col)]));
  };
  for (int row = 1; row < board.rows; ++row)
    for (int col = 1; col < board.cols; ++col) {
      const bool falling = IsDark(row - 1, col - 1);
      const Eigen::Array4f a = falling ? ink(row - 1, col - 1) : ink(row - 1, col);
      const Eigen::Array4f b = falling ? ink(row, col) : ink(row, col - 1);
      rectangles.push_back({col - e, row - e, col + e, row + e, -0.5f * (a + b)});
    }
}

void AddMargin(const SceneMarker& marker, std::vector<Rectangle>& rectangles) {
  const double m = marker.margin_cells;
  if (m <= 0) return;
  const double cols = marker.board.cols, rows = marker.board.rows;
  const Eigen::Array4f weight = Opaque(marker.inks.Of(marker.margin_colour));
  rectangles.push_back({-m, -m, cols + m, 0, weight});
  rectangles.push_back({-m, rows, cols + m, rows + m, weight});
  rectangles.push_back({-m, 0, 0, rows, weight});
  rectangles.push_back({cols, 0, cols + m, rows, weight});
}

/// Where a grown dark cell reaches over the board's rim, the margin is no longer seen.
void HideMargin(const SceneMarker& marker, int row, int col, const Rectangle& grown,
                std::vector<Rectangle>& rectangles) {
  if (marker.margin_cells <= 0) return;
  const Eigen::Array4f taken = -Opaque(marker.inks.Of(marker.margin_colour));
  const double rows = marker.board.rows, cols = marker.board.cols;
  const double top = std::max(grown.row0, 0.0), bottom = std::min(grown.row1, rows);
  if (row == 0) rectangles.push_back({grown.col0, grown.row0, grown.col1, 0, taken});
  if (row == marker.board.rows - 1) rectangles.push_back({grown.col0, rows, grown.col1, grown.row1, taken});
  if (col == 0) rectangles.push_back({grown.col0, top, 0, bottom, taken});
  if (col == marker.board.cols - 1) rectangles.push_back({cols, top, grown.col1, bottom, taken});
}

/// What is left of rectangles outside `hole`.
std::vector<Rectangle> CutOut(const std::vector<Rectangle>& rectangles, const Rectangle& hole) {
  std::vector<Rectangle> left;
  const auto add = [&](const Rectangle& piece) {
    if (piece.col0 < piece.col1 && piece.row0 < piece.row1) left.push_back(piece);
  };
  for (const Rectangle& r : rectangles) {
    const double top = std::clamp(hole.row0, r.row0, r.row1), bottom = std::clamp(hole.row1, r.row0, r.row1);
    add({r.col0, r.row0, r.col1, top, r.weight});
    add({r.col0, bottom, r.col1, r.row1, r.weight});
    add({r.col0, top, std::clamp(hole.col0, r.col0, r.col1), bottom, r.weight});
    add({std::clamp(hole.col1, r.col0, r.col1), top, r.col1, bottom, r.weight});
  }
  return left;
}

}  // namespace

std::vector<Rectangle> BoardRectangles(const SceneMarker& marker) {
  if (!marker.print.in_register()) return SeparatedRectangles(marker);
  const Board& board = marker.board;
  const double spread = marker.ink_spread_cells;
  std::vector<Rectangle> rectangles;
  AddMargin(marker, rectangles);
  for (int row = 0; row < board.rows; ++row)
    for (int col = 0; col < board.cols; ++col) {
      Rectangle cell{double(col), double(row), col + 1.0, row + 1.0, {}};
      if (spread > 0 && IsDark(row, col)) {
        cell = {col - spread, row - spread, col + 1 + spread, row + 1 + spread, {}};
        HideMargin(marker, row, col, cell, rectangles);
      } else if (spread > 0) {
        cell = LightCell(marker, row, col);
      }
      cell.weight = Opaque(marker.inks.Of(board.cells[static_cast<std::size_t>(row * board.cols + col)]));
      rectangles.push_back(cell);
    }
  if (spread > 0) AddSpread(marker, rectangles);
  return rectangles;
}

std::vector<Rectangle> OccluderRectangles(const SceneMarker& marker, const Occluder& occluder) {
  const Eigen::Array2d board(marker.board.cols, marker.board.rows);
  const Eigen::Array2d from = occluder.from.array() * board;
  const Eigen::Array2d to = occluder.to.array() * board;
  if (occluder.patches == 0) return {{from.x(), from.y(), to.x(), to.y(), Opaque(occluder.colour)}};
  const Eigen::Array2d size = to - from;
  const double pitch = size.maxCoeff() / occluder.patches;
  const int cols = std::max(1, static_cast<int>(std::lround(size.x() / pitch)));
  const int rows = std::max(1, static_cast<int>(std::lround(size.y() / pitch)));
  Random random(occluder.seed);
  std::vector<Rectangle> rectangles;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      Eigen::Vector3f colour;
      for (float& channel : colour) channel = static_cast<float>(random.Uniform(0.02, 0.9));
      rectangles.push_back({from.x() + size.x() * col / cols, from.y() + size.y() * row / rows,
                            from.x() + size.x() * (col + 1) / cols, from.y() + size.y() * (row + 1) / rows,
                            Opaque(colour)});
    }
  return rectangles;
}

std::vector<Rectangle> SeenRectangles(const SceneMarker& marker) {
  const double cols = marker.board.cols, rows = marker.board.rows;
  std::vector<Rectangle> seen = BoardRectangles(marker);
  for (const Occluder& occluder : marker.occluders) {
    seen = CutOut(
        seen, {occluder.from.x() * cols, occluder.from.y() * rows, occluder.to.x() * cols, occluder.to.y() * rows, {}});
    const std::vector<Rectangle> over = OccluderRectangles(marker, occluder);
    seen.insert(seen.end(), over.begin(), over.end());
  }
  return seen;
}

}  // namespace chequer
