#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "chequer/marker.h"

namespace chequer {

/// The kernels of a table file in the order of ids, and where each was found.
struct TableFile {
  std::vector<std::uint64_t> kernels;
  std::vector<std::string> places;  ///< "line 12" of each kernel
};

/// Reads a table: one kernel a line as KernelBits digits 0 and 1; blank lines and what follows # are skipped.
/// Throws std::runtime_error naming file, line and what would be right. @pre IsValid(size).
TableFile ReadTableFile(MarkerSize size, const std::filesystem::path& path);

}  // namespace chequer
