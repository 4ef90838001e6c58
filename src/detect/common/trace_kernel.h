#pragma once

#include <cstdint>
#include <optional>

#include "chequer/detect_trace.h"

namespace chequer {

/// The kernel of a board as its cells were seen, whatever code they are words of. Nothing where a kernel cell was not
/// seen or is in doubt, or where the candidate is no board that was found.
std::optional<std::uint64_t> KernelOf(const TraceCandidate& candidate);

}  // namespace chequer
