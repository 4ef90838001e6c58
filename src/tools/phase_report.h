#pragma once

#include <string>

#include "tools/phase_results.h"

namespace chequer {

/// Two tables for people, a line a phase and one for all: what was read, and how exact and how fast. Ends with a line's
/// end.
std::string DescribePhases(const PhaseRun& run);

/// A JSON object a line and phase, and one for all ("phase": null).
std::string PhasesJson(const PhaseRun& run);

}  // namespace chequer
