#pragma once

#include <Eigen/Core>

#include "chequer/detector.h"
#include "detect/common/board_geometry.h"

namespace chequer {

/// Where the last frames showed a board, and how evenly it goes on.
struct RecentPlaces {
  Eigen::Matrix3d last = Eigen::Matrix3d::Identity();  ///< plane_from_board one frame ago
  double last_s = 0;                                   ///< how long ago that was; 0: not known
  Eigen::Matrix3d before = Eigen::Matrix3d::Identity();
  double before_s = 0;  ///< how much earlier that was; 0: not known
  /// By how much it went and turned otherwise lately than as it did before, faster or slower by as much as it was: RMS,
  /// plane units and rad. Not known where the place before is not.
  double off = 0, turned_off = 0;
};

/// Makes of what a rolling shutter shows of a board that moves what is true when the row of its middle is exposed. A
/// point whose row is exposed t later is seen where it has got to by then, v t farther on: v is the derivative there of
/// the parabola through its last three places (of the line through two, where there are no more). By how much that may
/// be wrong goes into the information: of a board that is new, so much that its pose rests on what no motion shears (a
/// rigid body has six parameters, its homography eight). @param lens with a rolling shutter.
void UndoRollingShutter(const RecentPlaces& places, MarkerSize size, const Lens& lens, BoardMeasurement& measured);

}  // namespace chequer
