#include "simulate/outline.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulate/random.h"

namespace chequer {
namespace {

/// How far a piece of an outline may bend away from its chord, pixels: a hundredth of what is promised for positions.
constexpr double kMaxSagittaPx = 1e-4;

/// A rectangle in cells from the board's top left, and what it adds: reflectance times coverage, and coverage.
struct Rectangle {
  double col0, row0, col1, row1;
  Eigen::Array4f weight;
};

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

std::vector<Rectangle> BoardRectangles(const SceneMarker& marker) {
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

/// Draws rectangles of one marker's plane.
class Projector {
 public:
  Projector(const SceneMarker& marker, const CameraModel& camera) : marker_(marker), camera_(camera) {}

  Layer Draw(const std::vector<Rectangle>& rectangles) const {
    Layer layer;
    layer.low.setConstant(1e30);
    layer.high.setConstant(-1e30);
    for (const Rectangle& r : rectangles) AddRectangle(r, layer);
    return layer;
  }

 private:
  Eigen::Vector2d Pixel(const Eigen::Vector2d& cell) const {
    return camera_.Project(marker_.camera_from_marker * marker_.PointAt(cell.x(), cell.y()));
  }

  void AddRectangle(const Rectangle& r, Layer& layer) const {
    if (r.col1 <= r.col0 || r.row1 <= r.row0) return;
    const std::array<Eigen::Vector2d, 4> corners{
        {{r.col0, r.row0}, {r.col0, r.row1}, {r.col1, r.row1}, {r.col1, r.row0}}};
    // Down the left side and up the right one; a mirrored board runs the other way round.
    const Eigen::Array4f weight = marker_.mirrored ? Eigen::Array4f(-r.weight) : r.weight;
    for (std::size_t i = 0; i < 4; ++i) AddSide(corners[i], corners[(i + 1) % 4], weight, layer);
  }

  void AddSide(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Array4f& weight, Layer& layer) const {
    const int pieces = Pieces(a, b);
    Eigen::Vector2d from = Pixel(a);
    for (int i = 1; i <= pieces; ++i) {
      const Eigen::Vector2d to = Pixel(a + (b - a) * i / pieces);
      layer.edges.push_back({from, to, weight});
      layer.low = layer.low.cwiseMin(from);
      layer.high = layer.high.cwiseMax(from);
      from = to;
    }
  }

  /// So many that no piece bends more than kMaxSagittaPx: the bend falls with the square of the length.
  int Pieces(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
    if (camera_.kind == CameraModel::Kind::kPinhole) return 1;
    const Eigen::Vector2d from = Pixel(a);
    const Eigen::Vector2d along = (Pixel(b) - from).normalized();
    double bend = 0;
    for (const double t : {0.25, 0.5, 0.75}) {
      const Eigen::Vector2d offset = Pixel(a + t * (b - a)) - from;
      bend = std::max(bend, std::abs(offset.x() * along.y() - offset.y() * along.x()));
    }
    return std::clamp(static_cast<int>(std::ceil(std::sqrt(bend / kMaxSagittaPx))), 1, 256);
  }

  const SceneMarker& marker_;
  const CameraModel& camera_;
};

void SetGradient(const SceneMarker& marker, const CameraModel& camera, Layer& layer) {
  if (marker.gradient == 0) return;
  const Eigen::Vector2d direction(std::cos(marker.gradient_angle_rad), std::sin(marker.gradient_angle_rad));
  double low = 1e30, high = -1e30;
  for (const int row : {0, marker.board.rows})
    for (const int col : {0, marker.board.cols}) {
      const double at = direction.dot(camera.Project(marker.camera_from_marker * marker.PointAt(col, row)));
      low = std::min(low, at);
      high = std::max(high, at);
    }
  layer.fall = marker.gradient;
  layer.fall_direction = direction / (high - low);
  layer.fall_offset = -low / (high - low);
}

}  // namespace

std::vector<Layer> MakeLayers(const std::vector<SceneMarker>& markers, const CameraModel& camera) {
  std::vector<Layer> layers;
  for (const SceneMarker& marker : markers) {
    if (!IsDrawable(marker, camera)) continue;
    const Projector projector(marker, camera);
    layers.push_back(projector.Draw(BoardRectangles(marker)));
    SetGradient(marker, camera, layers.back());
    for (const Occluder& occluder : marker.occluders) {
      layers.push_back(projector.Draw(OccluderRectangles(marker, occluder)));
      SetGradient(marker, camera, layers.back());
    }
  }
  return layers;
}

}  // namespace chequer
