#pragma once

#include <array>

#include "chequer/marker.h"
#include "detect/fit/photometric_kernel.h"

namespace chequer {

/// Sums over the pixels that lie at one distance from edges, with a factor that all of a board share.
struct EdgeErrors {
  float score = 0;        ///< what they say of the edges' place: Σ of the derivative times the residual, weighted
  float information = 0;  ///< Σ of the derivative's weighted square: the variance of `score` where errors are noise
};

/// Edges across one of the board's axes, of which errors may be alike. Those that follow the pixels are grouped by
/// where in a block of JPEG they lie, which is so many pixels wide; where all corners lie alike, pixels by their
/// offset's parity.
struct AlikeEdges {
  static constexpr int kBlockPx = 8;
  /// Whole pixels, half of them on either side.
  static constexpr int kDistances = 16;
  /// Every how many of a lane's pixels are asked: enough of them share an error.
  static constexpr int kStride = 2;
  using Group = std::array<EdgeErrors, kDistances>;

  AlikeEdges() { group_of_lane.fill(-1); }

  std::array<Group, kBlockPx> errors{};
  /// Of each lane as it stands in memory; negative: none.
  std::array<int, 4 * kMaxCorners + LaneBlock::kGroup> group_of_lane;
};

/// What the pixels of lanes that are in a group leave, by where they lie beside their corners: whole pixels along both
/// axes of the board. Where edges follow the pixels and all corners lie alike between these, a fit follows most of what
/// moves all of them: it is left where edges meet, and there of all corners alike.
struct AlikePlaces {
  struct Errors {
    float sum = 0;  ///< of the deviations, as corners of one sign of contrast have them
    float square = 0, count = 0;
  };
  std::array<Errors, AlikeEdges::kDistances * AlikeEdges::kDistances> errors{};

  /// How much of the square of all pixels' deviations the corners share, beside what noise and chance make of that.
  double Shared() const;
};

/// Adds up the errors of all groups and places. @param input as the lanes were last evaluated with. @param places null:
/// they are not asked.
void AddEdgeErrors(const KernelInput& input, const LaneBlock& block, AlikeEdges& x, AlikeEdges& y, AlikePlaces* places);

}  // namespace chequer
