#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "detect/toolbox.h"

namespace chequer {

/// How wide the edges between dark and light cells are, pixels: contrast over steepest slope, median over the edges
/// between neighbouring corners. A sharp camera has 1.5 to 2.5; defocus and motion have more. 0 where nothing could be
/// measured.
/// @param corners rows × cols, row by row, image pixels; empty where not seen.
double EdgeWidthPx(const DetectionPlane& plane, std::span<const std::optional<Eigen::Vector2d>> corners, int rows,
                   int cols);

}  // namespace chequer
