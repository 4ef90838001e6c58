#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "chequer/marker.h"
#include "marker/kernel_code.h"

namespace chequer {

/// The most entries of a table.
inline constexpr std::size_t kMaxTableEntries = 65536;

/// Kernel i is the word of id i. Throws std::runtime_error on an empty or too long table, on a kernel with bits beyond
/// the size's and on two equal ones. `entry_names` say what to call the entries in messages; empty: by their ids.
std::unique_ptr<KernelCode> MakeTableCode(MarkerSize size, std::vector<std::uint64_t> kernels,
                                          std::span<const std::string> entry_names = {});

}  // namespace chequer
