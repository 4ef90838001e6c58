#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "detect/common/board_geometry.h"

namespace chequer {

/// What a corner's pixels say of where it lies.
struct CornerOff {
  int corner = 0;
  Eigen::Vector2d board = Eigen::Vector2d::Zero();  ///< where it is printed, cells
  Eigen::Vector2d bent = Eigen::Vector2d::Zero();   ///< how far from there the fit has it already, for a bend
  /// By which the board's coordinates of its pixels are off beyond that (BoardGeometry's moves), and its information.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
};

/// Paper that is not flat, as its corners show it: to second order, a point (x, y) of the board lies q₀ x² + q₁ xy + q₂ y²
/// out of the plane that touches the board in its middle (all in cells). A camera that sees the board at an angle sees
/// that as shifts along one direction, which no homography makes. Along the bend, the paper reaches less far than flat.
struct BentPaper {
  /// From the homography of flat paper to that of the plane in the board's middle: moves as BoardGeometry has them.
  BoardGeometry::Parameters moves = BoardGeometry::Parameters::Zero();
  /// What the bend leaves unknown of those moves: their covariance grows by this times its transpose.
  Eigen::Matrix<double, BoardGeometry::kParameters, 3> uncertain =
      Eigen::Matrix<double, BoardGeometry::kParameters, 3>::Zero();
  /// Of the corners' shifts, information times squares: what is left, and by how much that is less than without a bend.
  double left = 0, gain = 0;

  /// Where the bend has a corner, from where it is printed.
  Eigen::Vector2d BentAt(const BoardGeometry& flat, double focal, const Eigen::Vector2d& board) const;

  Eigen::Vector3d bend = Eigen::Vector3d::Zero();  ///< q
};

/// The bend of least squares of the shifts, or nothing where they do not determine one. Linear: for shifts that are small
/// against a cell. @param flat as fitted, its plane that of a calibrated lens. @param focal of the plane, pixels.
std::optional<BentPaper> FindBentPaper(const BoardGeometry& flat, double focal, std::span<const CornerOff> corners);

}  // namespace chequer
