#pragma once

namespace chequer {

// What both models of a board's picture are fitted within.

/// Corners that move farther in one step were never on a board.
inline constexpr double kRunawayPx = 3;
/// Where they moved farther, corners are placed anew.
inline constexpr double kFollowPx = 0.3;
/// Steps towards a predicted board end once they move it less, blurs: they leave errors of third order, 0.02 px.
inline constexpr double kStillFromPrediction = 0.4;
/// Standard deviations beyond which a pixel counts with less weight.
inline constexpr float kRobustLimit = 4;
/// Blur, pixels: half a pixel's own integration up to what still shows cells.
inline constexpr double kLeastBlur = 0.25, kMostBlur = 12;
/// Of a board's pixels, so many at most finish a fit of the model with all terms. What they leave out costs precision
/// that boards of cells as large have in plenty.
inline constexpr int kMostPixels = 6000;

}  // namespace chequer
