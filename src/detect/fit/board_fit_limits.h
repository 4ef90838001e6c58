#pragma once

namespace chequer {

// What both models of a board's picture are fitted within.

/// Corners that move farther in one step were never on a board.
inline constexpr double kRunawayPx = 3;
/// Steps towards a predicted board end once they move it less, blurs: they leave errors of third order, 0.02 px.
inline constexpr double kStillFromPrediction = 0.4;
/// Standard deviations beyond which a pixel counts with less weight.
inline constexpr float kRobustLimit = 4;
/// The plain model explains a board whose pixels leave fewer variances (a guess).
inline constexpr double kExplained = 2;
/// Blurs that are less, px, tell no motion, nor a dot gain by saturated pixels: a pixel's own square is 0.29, so they
/// are drawn, not seen, or sharpened (a guess).
inline constexpr double kLeastSeenBlur = 0.4;
/// Blur, pixels: half a pixel's own integration up to what still shows cells.
inline constexpr double kLeastBlur = 0.25, kMostBlur = 12;
/// Of a board's pixels, so many at most finish a fit of the model with all terms. What they leave out costs precision
/// that boards of cells as large have in plenty.
inline constexpr int kMostPixels = 6000;
/// Every how many pixels the first step uses: with half of them it comes near from any start, with a third from one
/// that knows the blur. Fewer tell the cells' levels too badly for the second step to judge what is occluded.
inline constexpr int kFirstStride = 2, kFirstStrideKnown = 3;
/// A plain fit that moved a board farther from where its pixels were chosen chooses them anew. Those at the rim are
/// chosen by where the board is thought to lie: a start that is 0.1 px off changes a pose by 0.1 standard deviations.
/// Corners that were found have boards off by as much.
inline constexpr double kOtherPixelsPx = 0.15;

}  // namespace chequer
