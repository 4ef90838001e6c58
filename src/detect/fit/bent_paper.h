#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>

#include "chequer/geometry.h"
#include "detect/common/board_geometry.h"
#include "detect/fit/linear_bend.h"

namespace chequer {

/// Where a corner is seen to lie.
struct SeenCorner {
  Eigen::Vector2d board = Eigen::Vector2d::Zero();  ///< where it is printed, cells
  Eigen::Vector2d plane = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< of the plane's point
};

class BentPaper;

/// How a board is seen.
struct BoardView {
  BoardGeometry geometry;                ///< as fitted, its plane that of a calibrated lens
  double focal = 1;                      ///< of the plane, pixels
  double cell_ratio = 1;                 ///< of a cell, height over width
  const BentPaper* fitted_as = nullptr;  ///< which bend the corners' pixels have had taken out, if any
};

/// Paper that is not flat: to second order, a point (x, y) of the board lies q₀ x² + q₁ xy + q₂ y² behind the plane
/// that touches the board in its middle (all in cells), and along the bend the paper reaches less far than flat.
class BentPaper {
 public:
  /// Pose and bend.
  static constexpr int kUnknowns = 9;

  /// The homography of the plane in the board's middle.
  const BoardGeometry& middle() const { return middle_; }
  const Eigen::Vector3d& bend() const { return bend_; }
  /// Where in the plane a point of the board is seen, and its derivative.
  Eigen::Vector2d Seen(const Eigen::Vector2d& board) const;
  Eigen::Matrix2d SeenByBoard(const Eigen::Vector2d& board) const;
  /// What the bend leaves unknown of middle(): the covariance of its moves grows by this times its transpose.
  const Eigen::Matrix<double, BoardGeometry::kParameters, 3>& uncertain() const { return uncertain_; }
  /// Of the corners' shifts, information times squares: what is left, and by how much that is less than without a bend.
  double left() const { return left_; }
  double gain() const { return gain_; }
  /// By how many standard deviations of this one's bend it is another, roughly.
  double DeviationsFrom(const BentPaper& other) const {
    return std::sqrt(gain_ * (bend_ - other.bend_).squaredNorm() / bend_.squaredNorm());
  }

 private:
  friend class BendSolver;
  RigidTransform camera_from_board_;  ///< in widths of a cell
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d bend_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d direction_ = Eigen::Vector2d::UnitX();  ///< of the bend
  double curvature_ = 0;                                  ///< along that, 1 / cells
  double focal_ = 1, cell_ratio_ = 1;
  BoardGeometry middle_;
  Eigen::Matrix<double, BoardGeometry::kParameters, 3> uncertain_ =
      Eigen::Matrix<double, BoardGeometry::kParameters, 3>::Zero();
  double left_ = 0, gain_ = 0;
};

/// What a bend has to gain to be one: so many times the variance of the corners' shifts, which is that of pixels or
/// more: print and demosaicing move corners, too, each by itself.
struct LeastBend {
  double times = 0;
  /// @param left what the bend leaves. @param corners whose shifts that is of.
  double Gain(double left, std::size_t corners) const;
};

/// Whether a bend may gain what it has to, roughly: by the corners' shifts from where the view has them, in one linear
/// step. Always where a bend was taken out already. 7,000 instructions for 25 corners; FindBentPaper() takes 400,000.
bool MayBeBent(const BoardView& view, std::span<const ShiftedCorner> corners, const LeastBend& least);

/// The pose and bend of least squares of the corners' places, or nothing where they do not determine one, or it gains
/// less than it has to. Pose and bend together: a bend looks like a tilt but for perspective, so the two poses in which
/// a flat board looks the same are both gone on from.
std::optional<BentPaper> FindBentPaper(const BoardView& view, std::span<const SeenCorner> corners,
                                       const LeastBend& least);

}  // namespace chequer
