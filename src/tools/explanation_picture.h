#pragma once

#include <span>
#include <string>

#include "tools/canvas.h"
#include "tools/explanation.h"
#include "tools/explanation_panel.h"

namespace chequer {

/// Of the bar with the legend above the picture.
inline constexpr double kHeadHeight = 86;

/// A bar with a line of text and what the colours mean.
void DrawHead(Canvas& canvas, double width, const std::string& line);

/// Peaks, corners, links, places of the second look and candidates of the region, each with its label; nothing is drawn
/// outside the region's picture. @param told candidates, in the order of their numbers.
void DrawPicture(Canvas& canvas, const PictureScale& to, const Explanation& explanation,
                 std::span<const std::size_t> told);

}  // namespace chequer
