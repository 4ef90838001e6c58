#pragma once

#include <Eigen/Core>

#include "detect/common/board_geometry.h"
#include "detect/fit/board_equations.h"

namespace chequer {

/// Two columns: one for the blue ink's place along x, one along y.
using RegisterColumns = Eigen::Matrix<double, BoardGeometry::kParameters, 2>;

/// Least squares for a board's geometry and for how far its blue ink was printed off the black one, by its corners.
/// The edges of blue cells lie where the blue ink does. A corner that has such edges moves by their share of the
/// offset; corners of black cells stay. So the corners tell the offset, and it pulls the geometry no longer. It has a
/// prior of mean 0: where all corners have the same share, only that tells it from a move of the board.
class InkRegister {
 public:
  /// A corner's own shift beyond the geometry, in cells, as its information and gradient.
  struct Corner {
    const CornerDerivative* by = nullptr;
    /// Which share of the edges across x, and across y, are the blue ink's: 0..1.
    Eigen::Vector2d share = Eigen::Vector2d::Zero();
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  };
  void Add(const Corner& corner);
  /// What the information added so far counts from here on, over what it counted.
  void Scale(double factor);

  struct Step {
    BoardGeometry::Parameters moves = BoardGeometry::Parameters::Zero();  ///< as BoardGeometry::MoveCoordinates()
    Eigen::Vector2d offset = Eigen::Vector2d::Zero();                     ///< cells
  };
  /// From an offset. Zeros where the corners do not determine the geometry. @param deviation of the prior, cells, > 0.
  Step Solve(const Eigen::Vector2d& offset, const Eigen::Vector2d& deviation) const;

  /// How well the moves of the geometry are known, if they are known to `information` while there is no offset.
  struct Known {
    BoardGeometry::Information information = BoardGeometry::Information::Zero();  ///< but for the columns
    /// By which the prior pulls them wrongly, for an offset of one standard deviation: the same in every frame.
    RegisterColumns by_prior = RegisterColumns::Zero();
  };
  Known After(const BoardGeometry::Information& information, const Eigen::Vector2d& deviation) const;

 private:
  /// How the geometry follows the offset where nobody knows of it.
  RegisterColumns Pulled() const;

  BoardGeometry::Information moves_ = BoardGeometry::Information::Zero();
  RegisterColumns common_ = RegisterColumns::Zero();
  Eigen::Matrix2d offset_ = Eigen::Matrix2d::Zero();
  BoardGeometry::Parameters moves_gradient_ = BoardGeometry::Parameters::Zero();
  Eigen::Vector2d offset_gradient_ = Eigen::Vector2d::Zero();
};

}  // namespace chequer
