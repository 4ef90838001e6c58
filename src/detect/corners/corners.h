#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <vector>

#include "detect/common/plane.h"
#include "detect/common/search_regions.h"
#include "detect/corners/corner_response.h"
#include "detect/corners/saddle.h"

namespace chequer {

/// A place with contrast enough that it may be a corner, of a peak that is one or that is not.
struct StrongPoint {
  Eigen::Vector2f position = Eigen::Vector2f::Zero();  ///< image pixels
  float contrast = 0;                                  ///< grey levels
};

/// The plane of an image and its halvings, with the peaks of their corner responses. Keeps its memory.
struct Pyramid {
  static constexpr int kLevels = 3;
  DetectionPlane base;
  std::array<BytePlane, kLevels - 1> halves;  ///< levels 1 and 2
  std::array<PeakScan, kLevels> scans;
  std::vector<std::uint64_t> occupied;  ///< scratch
  std::vector<RefusedPeak> refused;     ///< scratch
  /// Peaks of at least kStrongContrast that are no corners.
  std::vector<StrongPoint> strong;

  const BytePlane& level(int index) const {
    return index == 0 ? base.plane : halves[static_cast<std::size_t>(index - 1)];
  }
  /// Image pixel of a level's pixel.
  Eigen::Vector2f ToImage(Eigen::Vector2f p, int level_index) const {
    const float scale = static_cast<float>(1 << level_index);
    return p * scale + (Eigen::Vector2f::Constant((scale - 1) / 2) + base.Origin());
  }
  Eigen::Vector2f FromImage(const Eigen::Vector2f& p, int level_index) const {
    const float scale = static_cast<float>(1 << level_index);
    return (p - (Eigen::Vector2f::Constant((scale - 1) / 2) + base.Origin())) / scale;
  }
};

/// Peaks that are looked at in one level; beyond it, noise has won and the weakest are left out (a guess).
inline constexpr int kMaxPeaks = 60000;

/// Contrast of peaks that are remembered where they are no corners, grey levels: textured ground has less, print more
/// (a guess).
inline constexpr float kStrongContrast = 30;

/// A part of an image that is searched for corners.
struct ImagePart {
  int x = 0, y = 0;                   ///< where it begins in the image
  const KnownTiles* known = nullptr;  ///< where nothing is sought; null: it is sought everywhere
};

/// Replaces the contents of `corners` by those of one plane, in its own pixels. @param scan, refused scratch.
void FindCornersIn(const BytePlane& plane, PeakScan& scan, std::vector<Corner>& corners,
                   std::vector<RefusedPeak>& refused);

/// Fills the pyramid, then finds the corners of the image, in the pixels of the whole, at all its levels, each at the
/// finest level that shows it. Replaces the contents of `corners`. Returns the number of peaks that were looked at.
/// Corners of cells from 4 px, sharp, to cells behind 6 px of blur are found, to 0.3 px (RMS) of the level's pixel;
/// none twice within 2 px of its level. Where there is a lot to look at, the weakest peaks are left out; kMaxPeaks
/// bounds the rest. At 1920 × 1080: 0.7 ms where there is nothing, 0.8 ms with textured ground (1,500 corners of 7,000
/// peaks).
/// @param refused_px if given, gets the peaks that are no corners, in the image.
/// @param most_peaks that are looked at in all, the strongest.
/// @param part where `image` is a part of one, and which of its corners are known already.
int FindCorners(const ImageView& image, Pyramid& pyramid, std::vector<Corner>& corners,
                std::vector<Eigen::Vector2f>* refused_px = nullptr,
                std::size_t most_peaks = std::numeric_limits<std::size_t>::max(), const ImagePart& part = {});

}  // namespace chequer
