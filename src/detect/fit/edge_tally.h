#pragma once

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
};

}  // namespace chequer
