#pragma once

#include <Eigen/Core>
#include <array>

#include "chequer/geometry.h"

namespace chequer {

/// A point where four cells meet.
struct Corner {
  Eigen::Vector2f position = Eigen::Vector2f::Zero();  ///< image pixels
  /// Unit directions of the four edges that leave it, by growing angle (x towards y). Past rays 0 and 2 it gets
  /// lighter (the sector from ray 0 to ray 1 is light), past rays 1 and 3 darker.
  std::array<Eigen::Vector2f, 4> rays = Zeros<Eigen::Vector2f, 4>();
  float contrast = 0;  ///< grey levels between its light and dark sectors
  /// It is itself as light as its light sectors or as dark as the dark ones: where a motion has blurred the
  /// edges, or inside a cell that is narrower than the ring.
  bool ridge = false;
  float scale = 1;  ///< image pixels of one pixel of the plane it was found in
};

}  // namespace chequer
