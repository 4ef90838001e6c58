#pragma once

#include <cstdint>
#include <optional>

#include "chequer/detect_trace.h"
#include "detect/common/colours.h"
#include "detect/common/homography.h"
#include "detect/common/plane.h"
#include "detect/pose/plane_pose.h"

// What other modules build upon of the detector, beside its interface: lenses homographies and planes, robots the
// homographies of poses, what shows traces the groups of colours. All else is the detector's own.

namespace chequer {

/// The kernel of a board as its cells were seen, whatever code they are words of. Nothing where a kernel cell was not
/// seen or is in doubt, or where the candidate is no board that was found.
std::optional<std::uint64_t> KernelOf(const TraceCandidate& candidate);

}  // namespace chequer
