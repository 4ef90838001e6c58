#include "simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace chequer {
namespace {

std::string CheckMarker(const SceneMarker& marker) {
  const Board& board = marker.board;
  if (board.rows < 1 || board.cols < 1 ||
      board.cells.size() != static_cast<std::size_t>(board.rows) * static_cast<std::size_t>(board.cols))
    return "the board has no cells, or not rows × cols of them";
  if (board.cells.find_first_not_of("KWBY") != std::string::npos) return "cells must be of K, W, B, Y";
  if (!(marker.side_m > 0 && marker.side_m <= 100)) return "side_m must be above 0, at most 100";
  if (!(marker.margin_cells >= 0 && marker.margin_cells <= 20)) return "margin_cells must be from 0 to 20";
  if (std::string("KWBY").find(marker.margin_colour) == std::string::npos) return "margin_colour must be K, W, B or Y";
  if (!(marker.ink_spread_cells >= 0 && marker.ink_spread_cells <= kMostInkSpreadCells))
    return "ink_spread_cells must be from 0 to 0.4";
  if (marker.ink_spread_cells > 0 && !board.Alternates())
    return "ink_spread_cells must be 0 on a board that is no checkerboard";
  if (marker.margin_cells > 0 && marker.margin_cells < marker.ink_spread_cells)
    return "margin_cells must be 0 or at least ink_spread_cells";
  if (!(marker.print.scale.minCoeff() >= 0.8 && marker.print.scale.maxCoeff() <= 1.2))
    return "the print's scale must be from 0.8 to 1.2";
  const double farthest = std::max(marker.print.blue_shift_m.norm(), marker.print.yellow_shift_m.norm());
  if (!(farthest <= 0.5 * marker.CellSize())) return "the print's inks must lie within half a cell of each other";
  if (!(std::abs(marker.bend_per_m) * marker.side_m <= 2)) return "the paper must bend by no more than 2 rad";
  if (!(marker.highlight.strength >= 0 && marker.highlight.strength <= 5)) return "highlight must be from 0 to 5";
  if (!(marker.highlight.sigma > 0)) return "the highlight's sigma must be above 0";
  if (!(marker.gradient >= 0 && marker.gradient <= 1)) return "gradient must be from 0 to 1";
  if (!marker.camera_from_marker.translation.allFinite()) return "its position is not finite";
  if (std::abs(marker.camera_from_marker.rotation.norm() - 1) > 1e-6) return "its orientation is not of length 1";
  for (const Occluder& occluder : marker.occluders) {
    if (!(occluder.from.array() < occluder.to.array()).all()) return "an occluder must begin before it ends";
    if (occluder.patches < 0 || occluder.patches > 100) return "an occluder's patches must be from 0 to 100";
  }
  return marker.inks.Check();
}

bool FacesCamera(const RigidTransform& camera_from_paper) {
  const Eigen::Vector3d normal = camera_from_paper.rotation * Eigen::Vector3d::UnitZ();
  return normal.dot(camera_from_paper.translation) < 0;
}

}  // namespace

RigidTransform OnBentPaper(const Eigen::Vector2d& flat_m, double bend_per_m, double bend_angle_rad) {
  if (bend_per_m == 0) return {Eigen::Quaterniond::Identity(), {flat_m.x(), flat_m.y(), 0}};
  // The way along the cylinder is as long as that along the paper.
  const Eigen::Vector2d direction(std::cos(bend_angle_rad), std::sin(bend_angle_rad));
  const double way = direction.dot(flat_m), angle = bend_per_m * way;
  const Eigen::Vector2d bent = flat_m + (std::sin(angle) / bend_per_m - way) * direction;
  return {RotationFromVector({-angle * direction.y(), angle * direction.x(), 0}),
          {bent.x(), bent.y(), (std::cos(angle) - 1) / bend_per_m}};
}

Eigen::Vector2d SceneMarker::FlatPointAt(double col, double row) const {
  const Eigen::Vector2d cell = CellSize() * print.scale;
  const double x = (col - 0.5 * board.cols) * cell.x();
  return {mirrored ? -x : x, (0.5 * board.rows - row) * cell.y()};
}

Eigen::Vector3d SceneMarker::PointAt(double col, double row) const {
  return OnBentPaper(FlatPointAt(col, row), bend_per_m, bend_angle_rad).translation;
}

std::string Scene::Check() const {
  for (std::size_t i = 0; i < markers.size(); ++i)
    if (std::string wrong = CheckMarker(markers[i]); !wrong.empty())
      return "marker " + std::to_string(i) + " of the scene: " + wrong;
  return background.Check();
}

bool IsDrawable(const SceneMarker& marker, const CameraModel& camera) {
  const RigidTransform& pose = marker.camera_from_marker;
  if (!FacesCamera(pose)) return false;
  const double rim = std::max(marker.margin_cells, marker.ink_spread_cells);
  const Board& board = marker.board;
  for (const double row : {-rim, board.rows + rim})
    for (const double col : {-rim, board.cols + rim}) {
      const RigidTransform at =
          pose * OnBentPaper(marker.FlatPointAt(col, row), marker.bend_per_m, marker.bend_angle_rad);
      const Eigen::Vector3d& corner = at.translation;
      if (!FacesCamera(at)) return false;
      // 1 mm: nearer than any lens, and far enough from 0 for the division.
      if (!(corner.z() > 1e-3)) return false;
      const Eigen::Vector2d normalized = corner.head<2>() / corner.z();
      const auto back = camera.Undistort(camera.Distort(normalized));
      if (!back || (*back - normalized).norm() > 1e-6 * (1 + normalized.norm())) return false;
    }
  return true;
}

Eigen::Vector2d CenterPx(const SceneMarker& marker, const CameraModel& camera) {
  return camera.Project(marker.camera_from_marker.translation);
}

double SmallestCellPx(const SceneMarker& marker, const CameraModel& camera) {
  const auto pixel = [&](int col, int row) {
    return camera.Project(marker.camera_from_marker * marker.PointAt(col, row));
  };
  double smallest = std::numeric_limits<double>::infinity();
  for (int row = 0; row <= marker.board.rows; ++row)
    for (int col = 0; col <= marker.board.cols; ++col) {
      const Eigen::Vector2d here = pixel(col, row);
      if (col > 0) smallest = std::min(smallest, (here - pixel(col - 1, row)).norm());
      if (row > 0) smallest = std::min(smallest, (here - pixel(col, row - 1)).norm());
    }
  return smallest;
}

RigidTransform FacingPose(const Eigen::Vector3d& position, double heading_rad, double tilt_rad, double tilt_axis_rad) {
  // Half a turn about x brings y up and z towards the viewer into the camera's y down and z forward.
  const Eigen::Quaterniond facing(0, 1, 0, 0);
  const Eigen::Quaterniond heading(Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d axis(std::cos(tilt_axis_rad), std::sin(tilt_axis_rad), 0);
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(tilt_rad, axis));
  return {Canonical(tilt * heading * facing), position};
}

}  // namespace chequer
