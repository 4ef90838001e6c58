#pragma once

#include <array>
#include <memory>

#include "chequer/marker.h"
#include "marker/kernel_code.h"

namespace chequer {

/// Every kernel is a word: the id is the kernel as a number.
std::unique_ptr<KernelCode> MakeUnconstrainedCode(MarkerSize size);

/// Half of the kernel cells, rounded down, are saturated.
std::unique_ptr<KernelCode> MakeSaturationConstrainedCode(MarkerSize size);

/// Half of the dark and half of the light kernel cells, each rounded down, are saturated.
std::unique_ptr<KernelCode> MakeColorConstrainedCode(MarkerSize size);

/// The kernel bits of dark cells.
std::uint64_t DarkKernelBits(MarkerSize size);

}  // namespace chequer
