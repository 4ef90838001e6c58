#pragma once

#include <Eigen/Core>
#include <span>

#include "detect/board_pixels.h"
#include "detect/photometric_kernel.h"

namespace chequer {

/// How an image's point spread differs from a Gaussian of the same width: what pixels, lenses and a camera's own
/// filters do to edges. The first two terms of the Gram-Charlier series of a symmetric one, for a spread that is the
/// product of one function of x and of y.
struct EdgeShape {
  /// Of e^(−a²/2) He₃(a) and He₅(a), a in standard deviations, for upright edges; slanted ones have less.
  double third = 0, fifth = 0;
};

/// What the kernel adds for edges that cross `normal`, a direction in the image.
EdgeTerms TermsOf(const EdgeShape& shape, const Eigen::Vector2d& normal);

/// A step towards the shape and the width that the pixels show.
struct EdgeShapeStep {
  EdgeShape more;
  double blur_px = 0;
  double gain = 0;  ///< by which χ² falls
};

/// The least squares step of blur and shape from a Gaussian, by some 1500 of a board's pixels, with all else as it is.
/// Changes the lanes' noise and sums. @param used by corner. @param input as the lanes were last evaluated with.
/// @param normal_x, normal_y of the board's edges, in the image. Six evaluations of the kernel: 20 µs.
EdgeShapeStep FindEdgeShape(KernelInput input, const Eigen::Vector2d& normal_x, const Eigen::Vector2d& normal_y,
                            std::span<const bool> used, BoardPixels& pixels);

}  // namespace chequer
