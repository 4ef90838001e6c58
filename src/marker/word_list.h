#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "marker/likelihoods.h"

namespace chequer {

/// The most likely of a list of kernels.
struct ListChoice {
  std::size_t index = 0;
  double margin = 0;  ///< log-likelihood ratio over the second best; infinity where there is none
};

/// The most likely of the kernels; the first of equals. Nothing for an empty list. A few instructions a kernel and
/// eight bits: the costs of all values of each byte are tabled first. Allocates nothing.
std::optional<ListChoice> MostLikely(std::span<const std::uint64_t> kernels, const Likelihoods& likelihoods);

/// The first kernel that differs in at most `radius` bits.
std::optional<std::size_t> FindWithin(std::span<const std::uint64_t> kernels, std::uint64_t kernel, int radius);

/// The least number of bits in which two kernels of the list differ; bits + 1 where there are less than two kernels.
int MinDistance(std::span<const std::uint64_t> kernels, int bits);

}  // namespace chequer
