#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "detect/common/board_geometry.h"
#include "detect/common/visibility.h"
#include "detect/fit/bent_paper.h"
#include "detect/fit/board_equations.h"
#include "detect/fit/board_pixels.h"
#include "detect/fit/edge_noise.h"

namespace chequer {

// What a board's edges and corners may be off by alike, as they lie alike between the image's pixels, and what that
// makes of its covariance. How far they are off, its pixels tell (edge_noise.h, edge_tally.h).

/// A board's corners, and which of them a fit uses.
struct UsedCorners {
  const BoardPixels& pixels;
  const Visibility& visibility;

  bool Uses(int corner) const { return pixels.inside(corner) && visibility.ShowsCorner(corner); }
  /// act(corner) for those that are used.
  template <class Act>
  void ForEach(const Act& act) const {
    for (int corner = 0; corner < pixels.corners(); ++corner)
      if (Uses(corner)) act(corner);
  }
};

/// By corner and axis of the board: the group of its edge across that axis, whose edges share an error; −1: none.
using EdgeGroups = std::array<std::array<int, 2>, kMaxCorners>;

/// Of edges that follow the pixels, by where in a block of JPEG they lie. Nothing where none do.
std::optional<EdgeGroups> GroupEdgesAlongPixels(const UsedCorners& corners);
/// By the board's rows and columns of corners; of large boards, lines that are AlikeEdges::kBlockPx apart are one.
EdgeGroups GroupEdgesByLine(MarkerSize size);

/// Where corners lie in squares of so many pixels.
struct AlikePhases {
  Eigen::Vector2d middle_px = Eigen::Vector2d::Zero();
  double alike = 0;  ///< squared length of the mean of their phases: 1 where all have the same
};

/// If they lie so alike that what moves one of them by that moves all.
std::optional<AlikePhases> FindAlikePhases(const UsedCorners& corners, double period_px);

/// For each kind of edges, puts the lanes of corners that lie alike into groups of pixels whose offsets from their
/// corners have the same parity.
void GroupByParity(const UsedCorners& corners, const Eigen::Vector2d& middle_px, std::array<AlikeEdges, 2>& edges);

/// What the covariance of the moves has beside the pixels' noise if each group has one error that all its edges share,
/// which varies as the noise lets them. @param in_pixels information on the moves, in units of what pixels are worth.
/// @param pixel_variance in these.
BoardGeometry::Information CovarianceOfGroups(const BoardGeometry::Information& in_pixels, double pixel_variance,
                                              std::span<const ShiftedCorner> corners,
                                              std::span<const CornerDerivative> derivatives, const EdgeGroups& groups);

}  // namespace chequer
