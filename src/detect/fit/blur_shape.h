#pragma once

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

namespace chequer {

/// How a board's blur differs from a round one that is the same all over it: by the way that its points went during the
/// exposure, where that is so short that the blur is nearly a Gaussian's (MotionTerm is for longer ones). A board may
/// turn meanwhile, so that one side is blurred more than the other.
struct BlurShape {
  Eigen::Vector2d way_px = Eigen::Vector2d::Zero();  ///< of its middle, image pixels; there and back are the same
  double turn = 0;                                   ///< rad, in the image

  bool operator==(const BlurShape&) const = default;
  bool round() const { return way_px.isZero() && turn == 0; }
  /// Deviation of a round blur of the same variance, which is the lens's and a 24th of the way's square.
  double BlurPx(double lens_px) const { return std::sqrt(lens_px * lens_px + way_px.squaredNorm() / 24); }
  /// A point of the image sees a board that turns go by on a bent way: its mean lies so far off the one of the board's
  /// points, image pixels.
  Eigen::Vector2d BendPx() const { return turn / 12 * Eigen::Vector2d(-way_px.y(), way_px.x()); }
};

// A Value is that of one corner, or an array of those of several.

/// The blur: its deviations across edges of constant x and of constant y over that of a round one, and what it adds to
/// the correlation of the two.
template <class Value>
struct CornerBlur {
  Value wider_x, wider_y, skew;
};

/// What a way has of the blur, in the board's middle: shares of the variances across the two edges, and the covariance
/// over the root of both. Where a board turns, the blur across the edges of constant x gets narrower with each of its
/// standard deviations along y, as a share of it; and the reverse. (That it leans more or less makes no difference.)
struct WayInBlur {
  double share_x = 0, share_y = 0, skew = 0;
  double narrower_x = 0, narrower_y = 0;
};

/// What pixels say of the blur: products of derivatives with the residual, and their squares. By the mean and by half
/// the difference of the logarithms of the two deviations, and by the skew.
template <class Value>
struct CornerBlurSums {
  Value both_residual, both_square, uneven_residual, uneven_square, skew_residual, skew_square;
};

/// How much more a point goes for each radian of a turn, across the two edges.
template <class Value>
struct WayByTurn {
  Value x, y;
};

/// The shape of a board's blur, beside the fit of the rest (Gauss-Newton). The mean variance over the board stays,
/// which is the fit's own unknown, and a shape changes the light to both sides of an edge alike, as no move of the
/// board does: so neither needs the other in its equations.
class BlurShapeFit {
 public:
  /// @param across rows: unit vectors across the edges of constant x and of constant y, image.
  /// @param blur_px deviation of the round blur of the same variance.
  BlurShapeFit(const BlurShape& shape, const Eigen::Matrix2d& across, double blur_px);

  /// @param off_px from the board's middle.
  template <class Value>
  WayByTurn<Value> ByTurn(const Value& off_px_x, const Value& off_px_y) const {
    return {As<Value>(turned_(0, 0)) * off_px_x + As<Value>(turned_(0, 1)) * off_px_y,
            As<Value>(turned_(1, 0)) * off_px_x + As<Value>(turned_(1, 1)) * off_px_y};
  }
  /// @param square mean of ByTurn()'s square over the corners.
  void SetMeanSquare(double square);

  template <class Value>
  CornerBlur<Value> At(const WayByTurn<Value>& by_turn) const {
    const Blurred<Value> at = BlurredAt(by_turn);
    const Value by_variance = As<Value>(1 / variance_);
    return {sqrt(at.x * by_variance), sqrt(at.y * by_variance),
            As<Value>(kOfWay) * at.way_x * at.way_y / sqrt(at.x * at.y)};
  }
  WayInBlur InMiddle() const;
  /// What the light around a corner says. @pre the model had At() there. @param may_turn whether a round blur may
  /// become one of a turn on the spot: the same of all corners.
  template <class Value>
  void Add(const WayByTurn<Value>& by_turn, const CornerBlurSums<Value>& sums, bool may_turn);
  /// How much Σ w r² falls by a step, and the shape after it. A round blur stays one unless it falls by `least_gain`.
  double Step(double least_gain, BlurShape& shape) const;
  /// How much more of Σ w r² a round blur leaves than the shape before that step.
  double round_leaves() const { return round_leaves_; }

 private:
  /// Variance of what is spread evenly over a way, over the way's square.
  static constexpr double kOfWay = 1.0 / 12;

  /// Of a point: its way across the two edges, and the variances that come of it.
  template <class Value>
  struct Blurred {
    Value way_x, way_y, x, y;
  };
  template <class Value>
  Blurred<Value> BlurredAt(const WayByTurn<Value>& by_turn) const {
    const Value way_x = As<Value>(way_.x()) + As<Value>(shape_.turn) * by_turn.x,
                way_y = As<Value>(way_.y()) + As<Value>(shape_.turn) * by_turn.y;
    return {way_x, way_y, As<Value>(lens_) + As<Value>(kOfWay) * way_x * way_x,
            As<Value>(lens_) + As<Value>(kOfWay) * way_y * way_y};
  }
  template <class Value>
  static Value As(double value) {
    if constexpr (std::is_same_v<Value, double>)
      return value;
    else
      return Value::Constant(static_cast<typename Value::Scalar>(value));
  }
  template <class Value>
  static double Sum(const Value& values) {
    if constexpr (std::is_same_v<Value, double>)
      return values;
    else
      return values.sum();
  }
  /// Of a round blur: what a way makes of it, alike at all corners, and what a turn on the spot does. Both grow with
  /// their squares, so that no step of Gauss-Newton finds them.
  struct RoundSums {
    double uneven_residual = 0, uneven_square = 0, skew_residual = 0, skew_square = 0;
    double turn_residual = 0, turn_square = 0;  ///< by the turn's square
  };
  /// What a turn on the spot would change in a round blur there.
  template <class Value>
  void AddTurn(const WayByTurn<Value>& by_turn, const CornerBlurSums<Value>& sums);
  double StepOfRound(double least_gain, BlurShape& shape) const;

  BlurShape shape_;
  Eigen::Matrix2d across_ = Eigen::Matrix2d::Identity(), turned_ = Eigen::Matrix2d::Identity();
  Eigen::Vector2d way_ = Eigen::Vector2d::Zero();  ///< across the edges
  double variance_, mean_square_ = 0;
  double lens_;  ///< variance that is left without the way
  double round_leaves_ = 0;
  RoundSums round_;
  /// By the way across the two edges, and the turn.
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();  ///< the lower triangle
  Eigen::Vector3d gradient_ = Eigen::Vector3d::Zero();
};

template <class Value>
void BlurShapeFit::AddTurn(const WayByTurn<Value>& by_turn, const CornerBlurSums<Value>& sums) {
  // Half the deviations' logarithms, as in Add(); what the turn adds on the whole, the lens has less.
  const Value quarter = As<Value>(kOfWay / 4 / variance_), less = As<Value>(mean_square_ / 2);
  const Value log_x = quarter * (by_turn.x * by_turn.x - less), log_y = quarter * (by_turn.y * by_turn.y - less),
              skew = As<Value>(kOfWay / variance_) * by_turn.x * by_turn.y;
  const Value both = log_x + log_y, uneven = log_x - log_y;
  round_.turn_residual +=
      Sum<Value>(both * sums.both_residual + uneven * sums.uneven_residual + skew * sums.skew_residual);
  round_.turn_square += Sum<Value>(both * both * sums.both_square + uneven * uneven * sums.uneven_square +
                                   skew * skew * sums.skew_square);
}

template <class Value>
void BlurShapeFit::Add(const WayByTurn<Value>& by_turn, const CornerBlurSums<Value>& sums, bool may_turn) {
  if (shape_.round()) {
    round_.uneven_residual += Sum(sums.uneven_residual);
    round_.uneven_square += Sum(sums.uneven_square);
    round_.skew_residual += Sum(sums.skew_residual);
    round_.skew_square += Sum(sums.skew_square);
    if (may_turn) AddTurn(by_turn, sums);
    return;
  }
  const Blurred<Value> at = BlurredAt(by_turn);
  // The deviations' logarithms; what the way adds on the whole, the lens has less.
  const Eigen::Vector3d less = 0.5 * Eigen::Vector3d(way_.x(), way_.y(), shape_.turn * mean_square_);
  const Value half_x = As<Value>(kOfWay / 2) / at.x, half_y = As<Value>(kOfWay / 2) / at.y;
  const Value log_x[] = {half_x * (at.way_x - As<Value>(less[0])), half_x * As<Value>(-less[1]),
                         half_x * (at.way_x * by_turn.x - As<Value>(less[2]))};
  const Value log_y[] = {half_y * As<Value>(-less[0]), half_y * (at.way_y - As<Value>(less[1])),
                         half_y * (at.way_y * by_turn.y - As<Value>(less[2]))};
  const Value of_skew = As<Value>(kOfWay) / sqrt(at.x * at.y);
  const Value skew[] = {of_skew * at.way_y, of_skew * at.way_x,
                        of_skew * (at.way_x * by_turn.y + at.way_y * by_turn.x)};
  for (int row = 0; row < 3; ++row) {
    const Value both = log_x[row] + log_y[row], uneven = log_x[row] - log_y[row];
    const Value both_square = both * sums.both_square, uneven_square = uneven * sums.uneven_square,
                skew_square = skew[row] * sums.skew_square;
    gradient_[row] +=
        Sum<Value>(both * sums.both_residual + uneven * sums.uneven_residual + skew[row] * sums.skew_residual);
    for (int col = 0; col <= row; ++col)
      information_(row, col) += Sum<Value>(both_square * (log_x[col] + log_y[col]) +
                                           uneven_square * (log_x[col] - log_y[col]) + skew_square * skew[col]);
  }
  const auto round_leaves = [](const Value& value, const Value& residual, const Value& square) {
    return Sum<Value>(value * (As<Value>(2) * residual + value * square));
  };
  round_leaves_ += round_leaves(As<Value>(0.25) * log(at.x / at.y), sums.uneven_residual, sums.uneven_square) +
                   round_leaves(of_skew * at.way_x * at.way_y, sums.skew_residual, sums.skew_square);
}

}  // namespace chequer
