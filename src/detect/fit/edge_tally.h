#pragma once

#include <optional>

#include "detect/common/board_geometry.h"
#include "detect/fit/edge_noise.h"

namespace chequer {

/// How far the places of groups of edges vary beyond the noise of their pixels: JPEG, sharpening, demosaicing and
/// median filters move edges that follow the pixels by what depends on where they lie between them. What a board's own
/// edges share in full its fit follows, so that they do not tell of it; those of other boards and frames do, as it is
/// the camera's.
struct EdgeTally {
  double scores = 0;       ///< Σ of the groups' squared scores over a pixel's variance
  double information = 0;  ///< the same, expected where errors are noise
  double squares = 0;      ///< Σ of the squared information of each group

  void Add(const AlikeEdges& edges, double pixel_variance);
  void Add(const EdgeTally& other);
  /// So that what was added counts that share of what is added from here on.
  void Forget(double share_left);
  /// How many times as much the places vary as the noise tells, beside that: 0 where errors are noise, as the square of
  /// each distance's score is its information then, in the mean (a covariance of clusters: Cameron, Gelbach, Miller,
  /// "Robust inference with multiway clustering", 2011). What chance makes of that is left out, steadily.
  double More() const;
  /// The same for the covariance of a board whose own edges are those among these. Fits follow a part of such errors,
  /// so that residuals show less of them; most of all a board's own.
  double MoreOf(const EdgeTally& own) const;
};

/// What such errors make of where one board lies.
struct SharedEdgeErrors {
  EdgeTally own;  ///< of its edges that follow the pixels; empty where none do, or the plain model does not serve
  /// Covariance of the geometry's parameters, for each unit of EdgeTally::MoreOf; zeros where no edges follow the
  /// pixels.
  BoardGeometry::Information covariance = BoardGeometry::Information::Zero();
  double counted = 0;  ///< how many of these units the board's information holds

  /// Information that holds what `all` say instead; nothing where that is hardly anything else.
  std::optional<BoardGeometry::Information> Recounted(const BoardGeometry::Information& information,
                                                      const EdgeTally& all) const;
};

}  // namespace chequer
