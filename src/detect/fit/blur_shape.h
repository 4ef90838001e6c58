#pragma once

#include <Eigen/Core>
#include <cmath>

namespace chequer {

/// How a board's blur differs from a round one that is the same all over it: by the way that its points went during the
/// exposure, where that is so short that the blur is nearly a Gaussian's (MotionTerm is for longer ones). A board may
/// turn meanwhile, so that one side is blurred more than the other.
struct BlurShape {
  Eigen::Vector2d way_px = Eigen::Vector2d::Zero();  ///< of its middle, image pixels; there and back are the same
  double turn = 0;                                   ///< rad, in the image

  bool round() const { return way_px.isZero(); }
  /// Deviation of a round blur of the same variance, which is the lens's and a 24th of the way's square.
  double BlurPx(double lens_px) const { return std::sqrt(lens_px * lens_px + way_px.squaredNorm() / 24); }
  /// A point of the image sees a board that turns go by on a bent way: its mean lies so far off the one of the board's
  /// points, image pixels.
  Eigen::Vector2d BendPx() const { return turn / 12 * Eigen::Vector2d(-way_px.y(), way_px.x()); }
};

/// The blur at a corner: its deviations across edges of constant x and of constant y over that of a round one, and what
/// it adds to the correlation of the two.
struct CornerBlur {
  double wider_x = 1, wider_y = 1, skew = 0;
};

/// What pixels say of the blur at a corner: products of derivatives with the residual, and their squares. By the mean
/// and by half the difference of the logarithms of the two deviations, and by the skew.
struct CornerBlurSums {
  double both_residual = 0, both_square = 0, uneven_residual = 0, uneven_square = 0, skew_residual = 0, skew_square = 0;
};

/// The shape of a board's blur, beside the fit of the rest (Gauss-Newton). The mean variance over the board stays,
/// which is the fit's own unknown, and a shape changes the light to both sides of an edge alike, as no move of the
/// board does: so neither needs the other in its equations.
class BlurShapeFit {
 public:
  /// @param across rows: unit vectors across the edges of constant x and of constant y, image.
  /// @param blur_px deviation of the round blur of the same variance.
  BlurShapeFit(const BlurShape& shape, const Eigen::Matrix2d& across, double blur_px);

  /// By how much more a point goes for each radian of a turn, across the two edges. @param off_px from the board's
  /// middle.
  Eigen::Vector2d ByTurn(const Eigen::Vector2d& off_px) const { return turned_ * off_px; }
  /// @param square mean of ByTurn()'s square over the corners.
  void SetMeanSquare(double square);

  CornerBlur At(const Eigen::Vector2d& by_turn) const;
  /// What the light around a corner says. @pre the model had At() there.
  void Add(const Eigen::Vector2d& by_turn, const CornerBlurSums& sums);
  /// How much Σ w r² falls by a step, and the shape after it. A blur that a shape does not explain by `least_gain` more
  /// than a round one does stays round, or becomes it: so it has one whatever it began with.
  double Step(double least_gain, BlurShape& shape) const;

 private:
  /// Of a point: its way across the two edges, and the variances that come of it.
  struct Blurred {
    Eigen::Vector2d way = Eigen::Vector2d::Zero();
    double x = 0, y = 0;
  };
  Blurred BlurredAt(const Eigen::Vector2d& by_turn) const;
  double StepOfRound(double least_gain, BlurShape& shape) const;

  BlurShape shape_;
  Eigen::Matrix2d across_ = Eigen::Matrix2d::Identity(), turned_ = Eigen::Matrix2d::Identity();
  Eigen::Vector2d way_ = Eigen::Vector2d::Zero();  ///< across the edges
  double variance_, mean_square_ = 0;
  double lens_;              ///< variance that is left without the way
  double round_leaves_ = 0;  ///< by how much a round blur leaves more of Σ w r² than the shape
  CornerBlurSums sums_;
  /// By the way across the two edges, and the turn.
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient_ = Eigen::Vector3d::Zero();
};

}  // namespace chequer
