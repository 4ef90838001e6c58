#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "chequer/geometry.h"
#include "chequer/marker.h"
#include "detect/common/board_geometry.h"
#include "detect/common/light.h"

namespace chequer {

/// Ways that the points of a board may have gone while the image was exposed, image pixels, the likeliest first. There
/// and back are the same.
struct MotionBlurs {
  static constexpr std::size_t kMost = 3;
  std::array<Eigen::Vector2d, kMost> by_px = Zeros<Eigen::Vector2d, kMost>();
  std::size_t count = 0;
};

/// How a board moved. None if it did not, or by less than a third of a cell, or by more than 1.6, or if its cells are
/// narrower than 5 px. The harmonics of the checkerboard tell: along a way L, light that changes with frequency f is
/// damped to sin(πLf) / (πLf), by the lens to a Gaussian of f. One of them is right to 0.08 cells where the geometry is
/// right to a tenth of a cell; only along a side of the cells there are several. 0.1 ms for a board that has not moved,
/// 1 ms for one that has.
MotionBlurs FindMotionBlurs(const LightReader& reader, const Lens& lens, MarkerSize size,
                            const BoardGeometry& geometry);

}  // namespace chequer
