#pragma once

#include <Eigen/Core>
#include <vector>

#include "simulate/scene.h"

namespace chequer {

/// A rectangle in cells from the board's top left, and what it adds: reflectance times coverage, and coverage.
struct Rectangle {
  double col0 = 0, row0 = 0, col1 = 0, row1 = 0;
  Eigen::Array4f weight = Eigen::Array4f::Zero();
};

/// All that is printed of a marker. Overlapping rectangles add up.
std::vector<Rectangle> BoardRectangles(const SceneMarker& marker);

/// What lies on a marker.
std::vector<Rectangle> OccluderRectangles(const SceneMarker& marker, const Occluder& occluder);

/// The board, without what its occluders cover, and its occluders: nothing lies over anything else.
std::vector<Rectangle> SeenRectangles(const SceneMarker& marker);

}  // namespace chequer
