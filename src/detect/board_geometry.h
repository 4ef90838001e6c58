#pragma once

#include <Eigen/Core>
#include <optional>

#include "chequer/camera_model.h"
#include "chequer/geometry.h"
#include "chequer/marker.h"

namespace chequer {

// Frames of the detector:
//   board  cells, from the board's centre, x along the columns, y down the rows (z into the board)
//   plane  the image with its lens distortion taken out: focal length × the plane z = 1, or the image itself without a
//          calibration. Pixel-like units.
//   image  pixels

/// Takes points between the image and the plane.
class Lens {
 public:
  /// Without a calibration: plane and image are the same.
  Lens() = default;
  explicit Lens(const CameraModel& camera);

  bool calibrated() const { return calibrated_; }
  double focal() const { return focal_; }
  /// Nothing where the lens model has no inverse.
  std::optional<Eigen::Vector2d> ToPlane(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d ToImage(const Eigen::Vector2d& plane) const;
  /// With the derivative of the image point by the plane point.
  Eigen::Vector2d ToImage(const Eigen::Vector2d& plane, Eigen::Matrix2d* jacobian) const;

 private:
  CameraModel camera_;
  bool calibrated_ = false;
  double focal_ = 1;
};

/// Where a board lies: a pose if the lens is calibrated (6 parameters), else a homography (8).
class BoardGeometry {
 public:
  static constexpr int kMaxParameters = 8;
  using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;
  /// Columns beyond the number of parameters are zero: fixed sizes are several times quicker.
  using Derivative = Eigen::Matrix<double, 2, kMaxParameters>;

  /// @param cell_m side of a cell. @param camera_from_board board axes, metres.
  static BoardGeometry FromPose(const RigidTransform& camera_from_board, double cell_m, double focal);
  /// @param plane_from_board of points in cells.
  static BoardGeometry FromHomography(const Eigen::Matrix3d& plane_from_board);

  int parameters() const { return has_pose_ ? 6 : 8; }
  bool has_pose() const { return has_pose_; }
  const RigidTransform& camera_from_board() const { return camera_from_board_; }
  const Eigen::Matrix3d& plane_from_board() const { return plane_from_board_; }

  Eigen::Vector2d ToPlane(const Eigen::Vector2d& board) const;
  /// Derivative of the plane point by the board point.
  Eigen::Matrix2d PlaneByBoard(const Eigen::Vector2d& board) const;
  /// Derivative of the plane point by the parameters: for a pose (x, y, z, θx, θy, θz) as in MarkerPose::covariance.
  Derivative PlaneByParameters(const Eigen::Vector2d& board) const;
  /// Adds a small step of the parameters.
  void Add(const Parameters& step);

 private:
  void UpdateHomography();

  bool has_pose_ = false;
  RigidTransform camera_from_board_;
  double cell_m_ = 1;
  double focal_ = 1;
  Eigen::Matrix3d plane_from_board_ = Eigen::Matrix3d::Identity();
};

/// Turns the board's axes (y down, z into it) into the marker's (y up, z towards the viewer).
RigidTransform CameraFromMarker(const RigidTransform& camera_from_board);

/// Board coordinates of the inner corner (row, col), rows and cols counted from the first inner corner.
inline Eigen::Vector2d CornerOnBoard(MarkerSize size, int row, int col) {
  return {col + 1 - 0.5 * size.cols, row + 1 - 0.5 * size.rows};
}

}  // namespace chequer
