#pragma once

#include <vector>

#include "simulate/cast_shadow.h"
#include "simulate/linear_image.h"
#include "simulate/outline.h"

namespace chequer {

/// The lens and the aperture of a pixel: a Gaussian and a box of one pixel.
class PointSpread {
 public:
  /// @pre 0 ≤ sigma_px ≤ 50.
  explicit PointSpread(double sigma_px);

  /// Parts a pixel is divided into along each axis, so many that sharp edges are off by less than 1e-3 of their
  /// contrast.
  int parts() const { return parts_; }
  /// Pixels on each side that a pixel receives light from.
  int reach() const { return reach_; }
  /// (2 reach + 1) · parts weights by which a pixel sums up the parts of its neighbourhood along one axis; their sum
  /// is 1.
  const std::vector<float>& fine() const { return fine_; }
  /// 2 reach + 1 weights for a scene whose pixels are plain squares: `fine` summed over each pixel.
  const std::vector<float>& coarse() const { return coarse_; }

 private:
  int parts_ = 1;
  int reach_ = 0;
  std::vector<float> fine_;
  std::vector<float> coarse_;
};

/// The light that falls on each pixel: layers over a background of plain square pixels, through the lens. The
/// background is larger than the result by `rim` ≥ spread.reach() pixels on each side; its pixel (rim, rim) is the
/// result's first. @param shadow on the layers; the background is shaded already.
LinearImage SeeThroughLens(const LinearImage& background, int rim, const std::vector<Layer>& layers,
                           const PointSpread& spread, const CastShadow& shadow = {});

/// The first half of SeeThroughLens: the background alone.
LinearImage BlurBackground(const LinearImage& background, int rim, const PointSpread& spread);
/// The second half: draws layers into what BlurBackground gave of the same background.
void DrawLayers(const LinearImage& background, int rim, const std::vector<Layer>& layers, const PointSpread& spread,
                const CastShadow& shadow, LinearImage& out);

/// The mean over a straight camera motion of that length (pixels, centred) and direction (0 right, π/2 down). Borders
/// repeat the outermost pixel.
LinearImage Smear(const LinearImage& image, double length_px, double angle_rad);

}  // namespace chequer
