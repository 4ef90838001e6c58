#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "chequer/detector.h"
#include "simulate/stress.h"

namespace chequer::test {

/// The simulator's case of that tag. Throws std::runtime_error where there is none, so that no test passes without one.
StressCase CaseOf(std::string_view tag, const MarkerCode& code, std::uint64_t seed);

/// Draws a case and looks for markers of its code and side with its camera. @param noise_seed of the sensor.
std::vector<MarkerPose> Look(const StressCase& stress, const MarkerCode& code, std::uint64_t noise_seed);

}  // namespace chequer::test
