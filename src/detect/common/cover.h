#pragma once

#include <cstdint>
#include <span>

#include "chequer/marker.h"

namespace chequer {

/// What lies over a board hides cells side by side: a cell between occluded ones that looks like one of the board is a
/// part of the cover that happens to. Hides every cell that two of its neighbours are occluded of, until there is none.
/// @param occluded by cell, row by row.
void HideBetween(MarkerSize size, std::span<std::uint8_t> occluded);

}  // namespace chequer
