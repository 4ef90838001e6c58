#pragma once

#include <vector>

#include "simulate/board_rectangles.h"

namespace chequer {

/// All that is printed of a marker whose inks lie out of register: paper, and over it black, blue and yellow, each
/// where it was printed. Where inks lie over each other, their transmittances multiply (Demichel's overprints). Ink
/// does not reach beyond the paper.
std::vector<Rectangle> SeparatedRectangles(const SceneMarker& marker);

}  // namespace chequer
