#include "simulate/outline.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "simulate/board_rectangles.h"

namespace chequer {
namespace {

/// How far a piece of an outline may bend away from its chord, pixels: a hundredth of what is promised for positions.
constexpr double kMaxSagittaPx = 1e-4;

Layer EmptyLayer() {
  Layer layer;
  layer.low.setConstant(1e30);
  layer.high.setConstant(-1e30);
  return layer;
}

/// Draws rectangles of one marker's plane.
class Projector {
 public:
  Projector(const SceneMarker& marker, const CameraModel& camera, const MotionByRow& by_row = {})
      : marker_(marker), camera_(camera), by_row_(by_row), still_(by_row.step.isZero() && by_row.turn.isZero()) {}

  Layer Draw(const std::vector<Rectangle>& rectangles) const {
    Layer layer = EmptyLayer();
    Add(rectangles, 1, layer);
    return layer;
  }

  /// Adds a share of rectangles to a layer.
  void Add(const std::vector<Rectangle>& rectangles, float share, Layer& layer) const {
    for (Rectangle r : rectangles) {
      r.weight *= share;
      AddRectangle(r, layer);
    }
  }

 private:
  Eigen::Vector2d Pixel(const Eigen::Vector2d& cell) const {
    const RigidTransform& pose = marker_.camera_from_marker;
    const Eigen::Vector3d point = marker_.PointAt(cell.x(), cell.y());
    Eigen::Vector2d pixel = camera_.Project(pose * point);
    if (still_) return pixel;
    // It is seen in the row that is exposed when it gets there. Boards go a part of a row from a row to the next: each
    // round leaves a twentieth of the error at most.
    constexpr int kRounds = 5;
    for (int round = 0; round < kRounds; ++round) {
      const double rows = pixel.y() - by_row_.row;
      pixel = camera_.Project(RotationFromVector(rows * by_row_.turn) * (pose.rotation * point) + pose.translation +
                              rows * by_row_.step);
    }
    return pixel;
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
    if (camera_.kind == CameraModel::Kind::kPinhole && marker_.bend_per_m == 0) return 1;
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
  const MotionByRow by_row_;
  const bool still_;
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

/// Of a lamp's size and place, so it stands still where the marker moves.
void SetGlow(const SceneMarker& marker, const CameraModel& camera, Layer& layer) {
  const Highlight& highlight = marker.highlight;
  if (highlight.strength == 0) return;
  const auto pixel = [&](const Eigen::Vector2d& cell) {
    return camera.Project(marker.camera_from_marker * marker.PointAt(cell.x(), cell.y()));
  };
  const Eigen::Vector2d cells(marker.board.cols, marker.board.rows), at = highlight.at.cwiseProduct(cells);
  Glow glow;
  glow.peak = static_cast<float>(highlight.strength) * marker.inks.white.array();
  glow.center = pixel(at);
  Eigen::Matrix2d axes;  // of the spot
  axes.col(0) = pixel(at + Eigen::Vector2d::UnitX()) - glow.center;
  axes.col(1) = pixel(at + Eigen::Vector2d::UnitY()) - glow.center;
  axes *= highlight.sigma * cells.maxCoeff();
  glow.inverse_covariance = (axes * axes.transpose()).inverse();
  layer.glow = glow;
}

}  // namespace

Eigen::Array3f Glow::At(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d off = pixel - center;
  return peak * static_cast<float>(std::exp(-0.5 * off.dot(inverse_covariance * off)));
}

std::vector<Layer> MakeLayers(const std::vector<SceneMarker>& markers, const CameraModel& camera) {
  std::vector<Layer> layers;
  for (const SceneMarker& marker : markers) {
    if (!IsDrawable(marker, camera)) continue;
    const Projector projector(marker, camera);
    layers.push_back(projector.Draw(BoardRectangles(marker)));
    SetGradient(marker, camera, layers.back());
    SetGlow(marker, camera, layers.back());
    for (const Occluder& occluder : marker.occluders) {
      layers.push_back(projector.Draw(OccluderRectangles(marker, occluder)));
      SetGradient(marker, camera, layers.back());
    }
  }
  return layers;
}

std::vector<Layer> MakeMovingLayers(const std::vector<MovingMarker>& markers, const CameraModel& camera) {
  std::vector<Layer> layers;
  for (const MovingMarker& moving : markers) {
    SceneMarker marker = moving.marker;
    const std::vector<Rectangle> seen = SeenRectangles(marker);
    const float share = 1.0f / static_cast<float>(moving.camera_from_marker.size());
    Layer layer = EmptyLayer();
    if (IsDrawable(marker, camera)) SetGlow(marker, camera, layer);
    for (const RigidTransform& pose : moving.camera_from_marker) {
      marker.camera_from_marker = pose;
      if (IsDrawable(marker, camera)) Projector(marker, camera, moving.by_row).Add(seen, share, layer);
    }
    if (!layer.edges.empty()) layers.push_back(std::move(layer));
  }
  return layers;
}

}  // namespace chequer
