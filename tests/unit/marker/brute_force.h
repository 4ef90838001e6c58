#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "chequer/marker.h"

namespace chequer::test {

/// A code's words, to be looked through one by one.
class BruteForce {
 public:
  explicit BruteForce(const MarkerCode& code);
  /// Limited to ids of a roster.
  BruteForce(const MarkerCode& code, const Roster& roster);

  /// The least and the second least sum of |ratio| over contradicted cells, of all words; infinity where there is none.
  struct Costs {
    double best;
    double second;
  };
  Costs Evaluate(std::span<const float> ratios) const;

 private:
  std::vector<std::uint64_t> kernels_;
};

/// Sum of |ratio| over the cells whose sign contradicts the kernel.
double CostOfKernel(std::span<const float> ratios, std::uint64_t kernel);

/// Fails unless `decoded` is a word of the code with the least cost, the right margin and count of corrected cells.
void ExpectMostLikely(const MarkerCode& code, const BruteForce& reference, std::span<const float> ratios,
                      const std::optional<SoftDecoded>& decoded);

/// Ratios of one of several kinds: normal, of few values (ties), with erasures, of very different sizes.
std::vector<float> RandomRatios(std::mt19937_64& random, int bits);

}  // namespace chequer::test
