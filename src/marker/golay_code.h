#pragma once

#include <memory>

#include "chequer/marker.h"
#include "marker/kernel_code.h"

namespace chequer {

/// The extended binary Golay code on the first 24 kernel cells; the spare cells repeat the inverted data bits.
/// @pre at least 24 kernel cells.
std::unique_ptr<KernelCode> MakeGolayCode(MarkerSize size);

}  // namespace chequer
