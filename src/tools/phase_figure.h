#pragma once

#include <cstdint>
#include <vector>

#include "tools/phase_results.h"

namespace chequer {

/// A run over its time as PNG, with its phases: the share of boards that was read in each frame and what was read
/// wrong, the errors of the positions, and how long detection and publication took.
std::vector<std::uint8_t> DrawPhaseFigure(const PhaseRun& run);

}  // namespace chequer
