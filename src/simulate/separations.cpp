#include "simulate/separations.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace chequer {
namespace {

/// Nearer lines are one, cells.
constexpr double kSameLine = 1e-9;

/// One ink's share of a print, in cells.
struct Separation {
  char colour = 'K';
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double gain = 0;  ///< by which its cells grow

  /// Whether it lies at a point of the board. Grown cells reach by less than half a cell, so at most four can.
  bool At(const Board& board, double col, double row) const {
    for (const double y : {row - shift.y() - gain, row - shift.y() + gain})
      for (const double x : {col - shift.x() - gain, col - shift.x() + gain}) {
        const int r = static_cast<int>(std::floor(y)), c = static_cast<int>(std::floor(x));
        if (r < 0 || c < 0 || r >= board.rows || c >= board.cols) continue;
        if (board.cells[static_cast<std::size_t>(r * board.cols + c)] == colour) return true;
      }
    return false;
  }
};

class Overprint {
 public:
  explicit Overprint(const SceneMarker& marker) : marker_(marker), paper_(marker.inks.white.array().max(1e-6f)) {
    const Eigen::Array2d cell = marker.CellSize() * marker.print.scale.array();
    const double gain = marker.ink_spread_cells;
    inks_ = {{{'K', Eigen::Vector2d::Zero(), gain},
              {'B', (marker.print.blue_shift_m.array() / cell).matrix(), gain},
              {'Y', (marker.print.yellow_shift_m.array() / cell).matrix(), 0}}};
  }

  /// Where something may begin or end along an axis: 0 columns, 1 rows.
  std::vector<double> Lines(int axis) const {
    const double margin = marker_.margin_cells;
    const int count = axis == 0 ? marker_.board.cols : marker_.board.rows;
    std::vector<double> lines{-margin, 0, double(count), count + margin};
    for (const Separation& ink : inks_)
      for (int i = 0; i <= count; ++i)
        for (const double gain : {-ink.gain, ink.gain})
          lines.push_back(std::clamp(i + ink.shift[axis] + gain, -margin, count + margin));
    std::sort(lines.begin(), lines.end());
    const auto same = [](double a, double b) { return b - a < kSameLine; };
    lines.erase(std::unique(lines.begin(), lines.end(), same), lines.end());
    return lines;
  }

  Eigen::Array4f At(double col, double row) const {
    const Board& board = marker_.board;
    const bool on_margin = col < 0 || row < 0 || col > board.cols || row > board.rows;
    Eigen::Array3f colour = marker_.inks.Of(on_margin ? marker_.margin_colour : 'W').array();
    for (const Separation& ink : inks_)
      if (ink.At(board, col, row)) colour *= marker_.inks.Of(ink.colour).array() / paper_;
    return {colour[0], colour[1], colour[2], 1};
  }

 private:
  const SceneMarker& marker_;
  Eigen::Array3f paper_ = Eigen::Array3f::Ones();
  std::array<Separation, 3> inks_;
};

/// A row of rectangles, those of one colour that touch as one.
std::vector<Rectangle> RowBetween(const Overprint& print, const std::vector<double>& cols, double top, double bottom) {
  std::vector<Rectangle> row;
  for (std::size_t i = 0; i + 1 < cols.size(); ++i) {
    const Eigen::Array4f weight = print.At(0.5 * (cols[i] + cols[i + 1]), 0.5 * (top + bottom));
    if (!row.empty() && (row.back().weight == weight).all())
      row.back().col1 = cols[i + 1];
    else
      row.push_back({cols[i], top, cols[i + 1], bottom, weight});
  }
  return row;
}

bool Continues(const std::vector<Rectangle>& above, const std::vector<Rectangle>& below) {
  return std::equal(above.begin(), above.end(), below.begin(), below.end(), [](const Rectangle& a, const Rectangle& b) {
    return a.col0 == b.col0 && a.col1 == b.col1 && (a.weight == b.weight).all();
  });
}

}  // namespace

std::vector<Rectangle> SeparatedRectangles(const SceneMarker& marker) {
  const Overprint print(marker);
  const std::vector<double> cols = print.Lines(0), rows = print.Lines(1);
  std::vector<Rectangle> rectangles, above;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    std::vector<Rectangle> row = RowBetween(print, cols, rows[i], rows[i + 1]);
    if (Continues(above, row)) {
      for (Rectangle& rectangle : above) rectangle.row1 = rows[i + 1];
      continue;
    }
    rectangles.insert(rectangles.end(), above.begin(), above.end());
    above = std::move(row);
  }
  rectangles.insert(rectangles.end(), above.begin(), above.end());
  return rectangles;
}

}  // namespace chequer
