#pragma once

#include "detect/fit/blur_shape.h"
#include "detect/fit/photometric_kernel.h"

namespace chequer {

/// What a motion during the exposure makes of the edges and corners that the plain kernel is given, beside the
/// deviations and the correlation of their blur (BlurShapeFit::At()): a point spends as long everywhere on its way,
/// which is a box and no Gaussian; and where a board turns, edges blur unevenly along themselves. Edges are then right
/// to 6e-4 of their light, corners of ways that have half of the variance to 3e-3 (a Gaussian's: 1e-2, 2e-2).
/// @param input has what the lens makes of them; shorter ways leave that alone.
void AddMotion(const WayInBlur& way, KernelInput& input);

}  // namespace chequer
