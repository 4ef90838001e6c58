#pragma once

#include <memory>

#include "chequer/marker.h"
#include "marker/kernel_code.h"

namespace chequer {

/// A (shortened) Hamming code with an overall parity cell: corrects one wrong cell, detects two.
std::unique_ptr<KernelCode> MakeSecdedCode(MarkerSize size);

}  // namespace chequer
