#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/evaluation.h"

namespace chequer {

enum class TrackFigure : std::uint8_t {
  kLinear = 10,   ///< the publication's figure 10: errors of the position
  kAngular = 11,  ///< its figure 11: errors of the orientation
};

/// The errors of all runs as SVG: RMSE and MAE of each as bars, and every pose's error over its place along the track.
/// @pre at least one run has a track; those without are left out.
std::vector<std::uint8_t> DrawTrackFigure(TrackFigure figure, std::span<const Evaluation> runs);

}  // namespace chequer
