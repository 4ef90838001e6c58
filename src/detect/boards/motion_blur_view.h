#pragma once

#include <Eigen/Core>
#include <vector>

#include "detect/common/plane.h"

namespace chequer {

/// How unevenly a plane changes.
struct Change {
  Eigen::Vector2f least = Eigen::Vector2f::UnitX();  ///< direction along which it changes least
  float share = 0;                                   ///< mean square of the change along it over that across it
};

/// Within 2.6 cells of a point. A checkerboard in plain view changes alike along all directions; motion-blurred, it
/// turns into stripes along a diagonal of its cells. Every other pixel of every other row is asked: 3 µs for cells of
/// 10 px.
Change ChangeAround(const BytePlane& plane, const Eigen::Vector2f& middle, float cell_px);

/// Memory that is kept.
struct MotionBlurScratch {
  BytePlane turned;
  std::vector<std::uint8_t> smoothed;
  std::vector<int> far;
};

/// Makes a checkerboard of stripes that run along the rows of a view, whose middle is the board's: smoothes away all
/// but the first harmonics of its cells, then raises what changes along rows until it is as much as what changes across
/// them. Corners stay where they are. @param cell_px of the cells in the view, to a quarter.
void EvenOutChange(int cell_px, BytePlane& view, MotionBlurScratch& scratch);

}  // namespace chequer
