#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "chequer/hidden.h"
#include "detect/fit/board_pixels.h"
#include "detect/fit/photometric_kernel.h"

namespace chequer {

/// How an image's point spread differs from a Gaussian: a pixel sums up the light of its own square, and a camera that
/// smooths its images lets every pixel take up a part of its four neighbours (and the product of these of the corners).
/// What remains of the blur's variance is the lens's, a Gaussian.
struct EdgeSpread {
  double blur_px =
      0;  ///< standard deviation of all that together, along each axis; 0: edges are taken for a Gaussian's
  /// Share of the blur's variance, without the pixel's own, that is the smoothing's; below 0, neighbours are
  /// subtracted.
  double filter = 0;

  bool operator==(const EdgeSpread&) const = default;
};

/// The share of the light that an edge sends to pixels which lie `distance_px` towards its light side, 0 … 1.
/// @param normal across the edge, in the image.
double EdgeProfile(const EdgeSpread& shape, const Eigen::Vector2d& normal, double distance_px);

/// A profile as the kernel has it, by least squares. @param beyond what an edge of light 1 sends to pixels on its dark
/// side: one step from it, two steps, … A step is a fifth of the blur's deviation.
constexpr int kProfileSamples = 20;
constexpr double kProfileStep = 0.2;
EdgeTerms TermsOfProfile(const std::array<double, kProfileSamples>& beyond);

/// What the kernel takes for that profile: right to 0.01 where it has kinks (upright edges of smoothed pixels), to
/// 0.003 from 20 degrees off the image's axes on.
EdgeTerms TermsOf(const EdgeSpread& shape, const Eigen::Vector2d& normal);

/// What corners have for the same reason, where two edges meet nearly at right angles: a blur that is no Gaussian's is
/// not the same in all directions. Right to a quarter of it for smoothing by a sixth; lenses take most of it away.
CornerExcess CornerExcessOf(const EdgeSpread& shape, const Eigen::Vector2d& normal_x);

/// TermsOf() one shape for many normals, which are few different ones: those between are interpolated (to 1e-3).
/// Keeps what it has found.
class EdgeProfiles {
 public:
  void Set(const EdgeSpread& shape);
  EdgeTerms Across(const Eigen::Vector2d& normal);
  CornerExcess Between(const Eigen::Vector2d& normal_x) const { return CornerExcessOf(shape_, normal_x); }

 private:
  static constexpr int kNodes = 10;  ///< from upright to 45 degrees

  const EdgeTerms& Node(int node);

  EdgeSpread shape_;
  std::array<std::optional<EdgeTerms>, kNodes> nodes_;
};

/// The shape of least squares, by some 1500 of a board's pixels, with all but the blur as it is; nothing where it
/// explains no more than a Gaussian. Changes the lanes' noise and sums. @param hidden by corner: those that show count.
/// @param input as the lanes were last evaluated with. @param normal_x, normal_y of the board's edges, in the image.
/// Three to five evaluations of the kernel and shapes: 25 µs.
std::optional<EdgeSpread> FindEdgeSpread(KernelInput input, const Eigen::Vector2d& normal_x,
                                         const Eigen::Vector2d& normal_y, std::span<const Hidden> hidden,
                                         BoardPixels& pixels);

}  // namespace chequer
