#pragma once

#include <cstdint>
#include <vector>

#include "lens/calibrate_lens.h"

namespace chequer {

/// A picture (PNG) of a calibration: where in the image points were seen, each with what is left of it as a line drawn
/// large, and beside it the residuals about their middle and the result in numbers.
std::vector<std::uint8_t> DrawLensPicture(const LensCalibration& calibration);

}  // namespace chequer
