#pragma once

#include <memory>

#include "marker/kernel_code.h"

namespace chequer {

/// RM(1,4): 32 words of 16 bits, distance 8.
std::unique_ptr<KernelCode> MakeReedMullerCode();

/// The Nordstrom-Robinson code: 256 words of 16 bits, distance 6. Eight cosets of RM(1,4), each a quadratic form away.
std::unique_ptr<KernelCode> MakeNordstromRobinsonCode();

}  // namespace chequer
