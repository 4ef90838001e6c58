#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "chequer/geometry.h"
#include "detect/common/board_geometry.h"

namespace chequer {

/// A corner whose pixels say that it lies elsewhere, board coordinates, and how well they know.
struct ShiftedCorner {
  int corner = 0;
  Eigen::Vector2d board = Eigen::Vector2d::Zero();  ///< where it is printed
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
};

/// What the corners of a board that was fitted as flat tell of a bend of its paper.
struct BendEvidence {
  std::vector<ShiftedCorner> corners;  ///< by the variance of pixels; empty: they tell nothing
  double flat_variance = 1;            ///< over that of pixels, of the board that was fitted
};

/// What is known of paper before the image is looked at, standard deviations of q (bent_paper.h), 1 / cells: a board of
/// 6 cells lies on a cylinder of a radius of 30 cells.
inline constexpr double kBendKnownTo = 1.0 / 60;
/// The mean square of the distance from a corner of the pixels along one of its edges, which reach half a cell to
/// either side: they tell of that coordinate that the edge is square to.
inline constexpr double kAlongEdge = 1.0 / 12;

/// What q is multiplied with.
inline Eigen::Vector3d SquaresOf(const Eigen::Vector2d& board) {
  return {board.x() * board.x(), board.x() * board.y(), board.y() * board.y()};
}

/// The variance of corners' shifts by what is left of their squares, information times that: 1 is what the pixels have,
/// and the least. @param unknowns that were fitted to them.
inline double VarianceOfShifts(double left, std::size_t corners, int unknowns) {
  const double coordinates = 2 * static_cast<double>(corners);
  return std::max(left / std::max(coordinates - unknowns, 1.0), 1.0);
}

/// A homography and a bend of least squares, near a flat board, with what is known of paper: linear.
struct LinearBend {
  static constexpr int kMoves = BoardGeometry::kParameters, kBends = 3;
  /// The moves of a homography, a bend, and how far corners are off.
  static constexpr int kColumns = kMoves + kBends + 1;
  using Products = Eigen::Matrix<double, kColumns, kColumns>;

  /// @param products of all columns with each other, by information: the lower triangle. Nothing where the corners do
  /// not determine a homography.
  static std::optional<LinearBend> Of(const Products& products);
  /// What the bend leaves unknown of the homography: the covariance of its moves grows by this times its transpose.
  Eigen::Matrix<double, kMoves, kBends> UncertainMoves() const;

  Eigen::Matrix<double, kMoves, kBends> moves_by_bend = Eigen::Matrix<double, kMoves, kBends>::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< of the bend
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
  double square = 0, gain = 0;  ///< of the corners' shifts, information times squares: of all, and what it explains
  double left() const { return square - gain; }
};

/// The same for a board that lies there, by corners that are off by their shifts. 7,000 instructions for 25 corners.
/// @param camera_from_board in widths of a cell.
std::optional<LinearBend> FindLinearBend(const RigidTransform& camera_from_board, double cell_ratio,
                                         std::span<const ShiftedCorner> corners);

}  // namespace chequer
