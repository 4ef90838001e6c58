#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

namespace chequer {

/// What was seen of a kernel. Bit b is the bit of weight 2^b of the kernel as a number, so cell i of n is bit n − 1 −
/// i.
///
/// Decoders minimise the cost of a word: the sum of |log-likelihood ratio| over the cells in which it contradicts the
/// sign. That is the log-likelihood up to a constant, without the cancellation of sums of mixed signs.
struct Likelihoods {
  int bits = 0;
  std::array<double, 64> ratio{};  ///< log P(saturated) − log P(unsaturated) of each bit
  std::uint64_t hard = 0;          ///< bits whose ratio is positive
  std::uint64_t known = 0;         ///< bits whose ratio is not 0

  double Cost(int bit) const { return std::abs(ratio[static_cast<std::size_t>(bit)]); }
};

/// From ratios in the order of cells. @pre at most 64, finite.
Likelihoods LikelihoodsOfCells(std::span<const float> ratio_of_cell);

/// Recomputes `hard` and `known` after a change of ratios.
void ClassifyBits(Likelihoods& likelihoods);

/// The sum of |ratio| over the bits in which a kernel contradicts the hard decision.
double CostOf(const Likelihoods& likelihoods, std::uint64_t kernel);

/// How many known bits of the hard decision a kernel contradicts.
int CountContradicted(const Likelihoods& likelihoods, std::uint64_t kernel);

}  // namespace chequer
