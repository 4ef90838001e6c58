#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "chequer/marker.h"
#include "detect/common/light.h"

namespace chequer {

/// A board that was read, and how well.
struct SeenBoard {
  std::size_t index = 0;  ///< whose it is, for those who ask
  Eigen::Vector2d center_px{0, 0};
  PixelBox box;
  MarkerSize size;
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  bool has_id = false;
  int corners_used = 0;
  double rms_px = 0;
};

/// Whether the middle of a board lies on another.
bool LiesOn(const Eigen::Matrix3d& plane_from_board, const Eigen::Matrix3d& plane_from_other, MarkerSize size_of_other);

/// Takes boards out of `seen` that are there twice, by groups of corners that did not hang together or by levels of the
/// image that both showed it, and appends their indices to `worse`: those whose middle lies in the middle of one that
/// is known better, with an id, by more corners, or to less deviation; and those without an id whose middle lies anywhere
/// on one that was read, or the other way round: they are parts of it, some cells off. No board that only touches another
/// lies so.
/// Reorders `seen`; n log n for n of them.
void TakeOutTwins(std::vector<SeenBoard>& seen, std::vector<std::size_t>& worse);

}  // namespace chequer
