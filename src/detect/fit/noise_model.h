#pragma once

#include <array>
#include <span>

#include "chequer/hidden.h"
#include "detect/fit/board_pixels.h"

namespace chequer {

/// The variance of a pixel, by channel: read noise and rounding, and shot noise that grows with the light.
struct NoiseModel {
  std::array<float, 3> floor{};
  std::array<float, 3> slope{};
};

/// Where nothing is known: mostly shot noise, the shares as in common cameras. `lightest` is the most light of a cell.
NoiseModel UnknownNoise(float lightest);

/// From what the fit leaves over, two points of the line: one from the pixels that are darker than their corner's
/// middle, one from the lighter ones. Channels with too few pixels keep what `noise` has.
/// @param hidden by corner: those that show count. @param channel_of_phase 0 … 2 by parity of x + 2 · parity of y.
void EstimateNoise(const BoardPixels& pixels, std::span<const Hidden> hidden,
                   const std::array<int, 4>& channel_of_phase, NoiseModel& noise);

}  // namespace chequer
