#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace chequer {

/// The light on a board that the edge of a shadow crosses, over that beside the shadow: it falls across a line as the
/// integral of a normal distribution does, which is what a round lamp and the lens make of the edge of what is in the
/// lamp's way.
class ShadowEdge {
 public:
  enum Parameter { kTakes, kDirection, kOffset, kLogWidth, kParameters };
  using Parameters = Eigen::Vector4d;

  /// Share of the light; from the line into the shadow, radians from the board's x axis towards its y axis; of the line
  /// from the board's middle in that direction, cells; logarithm of the standard deviation, cells. Kept within bounds:
  /// no shadow takes all light, or is sharper or softer than any lamp's and lens's.
  explicit ShadowEdge(const Parameters& values);
  const Parameters& values() const { return values_; }

  /// How deep a point of the board lies in the shadow: 0 beside it, 1 where it takes all that it takes.
  double DepthAt(const Eigen::Vector2d& board) const;
  /// What it leaves of the light at a point of the board, to 1e-5.
  double At(const Eigen::Vector2d& board) const;
  /// Its derivatives there, by the point and by the parameters.
  Eigen::Vector2d SlopeAt(const Eigen::Vector2d& board) const;
  Parameters ByParameters(const Eigen::Vector2d& board) const;
  /// Whether the light differs within so many cells of a point.
  bool Crosses(const Eigen::Vector2d& board, double reach) const;

 private:
  double Across(const Eigen::Vector2d& board) const { return (normal_.dot(board) - values_[kOffset]) * per_width_; }

  Parameters values_ = Parameters::Zero();
  Eigen::Vector2d normal_ = Eigen::Vector2d::Zero();
  double per_width_;
};

/// Light of a part of a light cell, half a cell wide.
struct LitPart {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< on the board, cells
  double light = 0;
  bool saturated = false;  ///< its cell's ink
};

/// The edge of least squares over parts of both inks, each with a light of its own. Nothing where an edge does not
/// explain most of what they differ by, or they are too few. 0.3 ms.
std::optional<ShadowEdge> FindShadowEdge(std::span<const LitPart> parts);

}  // namespace chequer
