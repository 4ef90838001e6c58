#pragma once

#include <Eigen/Core>
#include <algorithm>
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

  /// By how much later its last row is exposed than its first, seconds; 0 without a rolling shutter. And a row than the
  /// one above it.
  double rows_read_s() const { return calibrated_ ? camera_.rows_read_ms / 1000 : 0; }
  double row_s() const { return calibrated_ ? rows_read_s() / camera_.height : 0; }

  /// Whether the calibration says how far it may be off.
  bool uncertain() const { return uncertain_; }
  /// How far the plane point that is seen at a fixed pixel lies from where the calibration has it: columns of one
  /// standard deviation each, independent of each other, the same for all points. Zero where it is not known.
  Eigen::Matrix<double, 2, 9> PlaneByCalibration(const Eigen::Vector2d& plane) const;

 private:
  CameraModel camera_;
  /// Its product with itself transposed is the calibration's covariance.
  LensCovariance deviations_ = LensCovariance::Zero();
  bool uncertain_ = false;
  bool calibrated_ = false;
  double focal_ = 1, by_focal_ = 1;
};

/// Half the side of the square that tells a cell's light before it is fitted, px: a share of the cell's, and at most so
/// much (guesses).
inline double SampledHalfPx(double cell_px) {
  constexpr double kShare = 0.3, kMostPx = 2.5;
  return std::min(kShare * cell_px, kMostPx);
}

/// Where a board lies: the homography from board to plane, its last entry 1.
class BoardGeometry {
 public:
  static constexpr int kParameters = 8;
  /// The first eight entries of the homography, row by row.
  using Parameters = Eigen::Matrix<double, kParameters, 1>;
  using Information = Eigen::Matrix<double, kParameters, kParameters>;
  using Derivative = Eigen::Matrix<double, 2, kParameters>;

  BoardGeometry() = default;
  explicit BoardGeometry(const Eigen::Matrix3d& plane_from_board)
      : plane_from_board_(plane_from_board / plane_from_board(2, 2)) {}

  const Eigen::Matrix3d& plane_from_board() const { return plane_from_board_; }
  Parameters parameters() const;

  Eigen::Vector2d ToPlane(const Eigen::Vector2d& board) const {
    const Eigen::Matrix3d& h = plane_from_board_;
    const double x = board.x(), y = board.y(), inverse = 1 / (h(2, 0) * x + h(2, 1) * y + h(2, 2));
    return {(h(0, 0) * x + h(0, 1) * y + h(0, 2)) * inverse, (h(1, 0) * x + h(1, 1) * y + h(1, 2)) * inverse};
  }
  /// Derivative of the plane point by the board point.
  Eigen::Matrix2d PlaneByBoard(const Eigen::Vector2d& board) const;
  /// Of a square as large as the cell in the board's middle, plane units.
  double CellSide() const;
  /// Of a board point.
  struct Local {
    Eigen::Vector2d plane = Eigen::Vector2d::Zero();
    double depth = 1;  ///< the homography's third coordinate
    Eigen::Matrix2d plane_by_board = Eigen::Matrix2d::Zero();
  };
  Local At(const Eigen::Vector2d& board) const {
    const Eigen::Matrix3d& h = plane_from_board_;
    const double x = board.x(), y = board.y(), depth = h(2, 0) * x + h(2, 1) * y + h(2, 2);
    const double inverse = 1 / depth;
    Local local;
    local.depth = depth;
    local.plane = {(h(0, 0) * x + h(0, 1) * y + h(0, 2)) * inverse, (h(1, 0) * x + h(1, 1) * y + h(1, 2)) * inverse};
    for (int row = 0; row < 2; ++row)
      for (int col = 0; col < 2; ++col)
        local.plane_by_board(row, col) = (h(row, col) - local.plane[row] * h(2, col)) * inverse;
    return local;
  }
  /// Derivative of the plane point by the parameters.
  Derivative PlaneByParameters(const Eigen::Vector2d& board) const;
  /// Adds a step of the parameters.
  void Add(const Parameters& step);

  // Another eight parameters, which keep the board's scale: small moves m of the board coordinates (x, y) of fixed
  // points of the plane,
  //   δx = m₀ + m₁ x + m₂ y + x (m₆ x + m₇ y),  δy = m₃ + m₄ x + m₅ y + y (m₆ x + m₇ y).

  /// The derivative of the move of coordinate `axis` by the parameters.
  static Parameters MoveByParameters(const Eigen::Vector2d& board, int axis) {
    const double x = board.x(), y = board.y(), along = board[axis];
    if (axis == 0) return {1, x, y, 0, 0, 0, along * x, along * y};
    return {0, 0, 0, 1, x, y, along * x, along * y};
  }
  /// The move by parameters m. @param by_x, by_y MoveByParameters() of the two axes: only what is not zero in them is
  /// looked at.
  template <class Moves>
  static Eigen::Vector2d Move(const Parameters& by_x, const Parameters& by_y, const Eigen::MatrixBase<Moves>& m) {
    return {m[0] + by_x[1] * m[1] + by_x[2] * m[2] + by_x[6] * m[6] + by_x[7] * m[7],
            m[3] + by_y[4] * m[4] + by_y[5] * m[5] + by_y[6] * m[6] + by_y[7] * m[7]};
  }
  /// Moves the coordinates of all points of the plane, to first order.
  void MoveCoordinates(const Parameters& moves);
  /// The derivative of parameters() by moves.
  Information ParametersByMoves() const;
  /// The information on parameters() that information on moves is.
  Information FromMoves(const Information& of_moves) const;

 private:
  Eigen::Matrix3d plane_from_board_ = Eigen::Matrix3d::Identity();
};

/// Turns the board's axes (y down, z into it) into the marker's (y up, z towards the viewer).
RigidTransform CameraFromMarker(const RigidTransform& camera_from_board);

/// A point of a board, by default its middle, in the plane and in the image.
struct BoardPoint {
  BoardPoint(const BoardGeometry& geometry, const Lens& lens, const Eigen::Vector2d& board = Eigen::Vector2d::Zero())
      : plane(geometry.ToPlane(board)),
        pixel(lens.ToImage(plane, &pixel_by_plane)),
        pixel_by_board(pixel_by_plane * geometry.PlaneByBoard(board)) {}

  Eigen::Matrix2d pixel_by_plane = Eigen::Matrix2d::Identity();  ///< before `pixel`, which is found with it
  Eigen::Vector2d plane = Eigen::Vector2d::Zero(), pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d pixel_by_board = Eigen::Matrix2d::Identity();
};

/// Board coordinates of the inner corner (row, col), rows and cols counted from the first inner corner.
inline Eigen::Vector2d CornerOnBoard(MarkerSize size, int row, int col) {
  return {col + 1 - 0.5 * size.cols, row + 1 - 0.5 * size.rows};
}

/// Calls visit(cell, row, col) for every cell of a board, row by row.
template <class Visit>
void ForCells(MarkerSize size, const Visit& visit) {
  std::size_t cell = 0;
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) visit(cell++, row, col);
}

/// Board coordinates of the middle of a cell, counted row by row.
inline Eigen::Vector2d MiddleOfCell(MarkerSize size, int cell) {
  return {cell % size.cols + 0.5 - 0.5 * size.cols, cell / size.cols + 0.5 - 0.5 * size.rows};
}

/// The cells around a corner, both counted row by row: towards −x −y, +x −y, −x +y, +x +y.
inline std::array<int, 4> CellsAround(MarkerSize size, int corner) {
  const int first = corner / (size.cols - 1) * size.cols + corner % (size.cols - 1);
  return {first, first + 1, first + size.cols, first + size.cols + 1};
}

}  // namespace chequer
