#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/long_tally.h"

namespace chequer::bench {

/// The least recall that a phase of the reference stream must have without a budget; of its calm phases, and those of
/// all other streams, 1. Nothing where none is named.
std::optional<double> LeastRecall(std::string_view stream, std::string_view phase);

/// The tables of a run, for people: recall and mistakes, errors over covariances, and work relative to the median of
/// the same stream's calm phases. What misses its bound is marked with "!".
std::string DescribeRun(const std::vector<PhaseTally>& phases);

/// Memory over the run, in ten steps or so.
std::string DescribeMemory(const MemoryWatch& watch);

}  // namespace chequer::bench
