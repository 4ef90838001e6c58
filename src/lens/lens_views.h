#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace chequer {

/// A point of a target that was identified in an image.
struct SeenPoint {
  int board = 0;                                         ///< which board of the target, from 0
  Eigen::Vector2d on_board_m = Eigen::Vector2d::Zero();  ///< on the board's plane, x right, y up, metres
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();       ///< centre of the top-left pixel at (0, 0)
};

/// What one image shows of the target. A target is one board or several that are fixed to one flat sheet; how they lie
/// on it need not be known.
struct LensView {
  std::string name;  ///< of the image, for messages
  std::vector<SeenPoint> points;
  double edge_px = 0;    ///< width of the edges between cells, from dark to light; 0 where it was not measured
  double flat_rms_px = 0;  ///< how far corners lie from flat boards, median of them; 0 where it was not measured
  bool gave_up = false;  ///< the search took too long: nothing is known of the image
};

}  // namespace chequer
