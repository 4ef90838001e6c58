#pragma once

#include <cstdint>
#include <span>

#include "chequer/marker.h"

namespace chequer {

/// Whether what shows of a board agrees with the border just as well where the board lies turned, shifted, or both.
/// That is so of one 6 × 6 board in sixteen of which two lines are occluded: turned by half and shifted by two lines,
/// its sides are the same, and the line that becomes the border may be like it. @param occluded, saturated as seen,
/// border as it should be: by cell, row by row.
bool AgreesElsewhere(MarkerSize size, std::span<const std::uint8_t> occluded, std::span<const std::uint8_t> saturated,
                     std::span<const std::uint8_t> border);

}  // namespace chequer
