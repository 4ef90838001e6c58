#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "detect/common/plane.h"
#include "detect/corners/corners.h"

namespace chequer {

/// Standard deviation of the corners of a board along a side, cells: √2 for five.
inline constexpr float kSpreadCells = 1.41f;

/// A place in an image where a board may be: where its corners lie, or would, as their mean and the axes of their
/// spread.
struct Place {
  Eigen::Vector2f middle = Eigen::Vector2f::Zero();
  Eigen::Matrix2f axes = Eigen::Matrix2f::Identity();  ///< columns, the longer first; not mirrored
  Eigen::Vector2f spread = Eigen::Vector2f::Ones();    ///< standard deviations along them, px
  int count = 0;                                       ///< of points

  /// Of a board's cells, the shorter side.
  float cell_px() const { return spread[1] / kSpreadCells; }
};

/// Round what lies up to `reach` away from a middle along two axes.
std::array<Eigen::Vector2f, 4> OutlineAround(const Eigen::Vector2f& middle, const Eigen::Matrix2f& axes,
                                             const Eigen::Vector2f& reach);

/// The place of the points that lie within reach of another. Corners of an even lattice lie within 2.83 spreads of
/// their middle; the reach is a little more, so that a place grows where points go on.
Place GatherPoints(std::span<const StrongPoint> points, const Place& place);
/// Whether a point lies within that reach.
bool IsWithinReach(const Place& place, const Eigen::Vector2f& point);

/// The place around a point where a plane changes from pixel to pixel as much as within `radius` of that point: all
/// over a board of narrow cells it does, whichever of its corners show. It spreads as the corners of a board that fills
/// it would; `count` is left 0. Nothing where that goes on for farther than over a board whose cells are 5.5 px high
/// and 35 px wide, or along a line, which is given up on the way, or where there is about as much of it around. A
/// quarter of the pixels is asked: 4 µs.
/// @param middle, radius, and the result, pixels of the plane.
std::optional<Place> PlaceOfChange(const BytePlane& plane, const Eigen::Vector2f& middle, float radius);

}  // namespace chequer
