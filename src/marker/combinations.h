#pragma once

#include <cstdint>

namespace chequer {

/// n over k; 0 where k > n. @pre 0 ≤ n ≤ 64, k ≥ 0. Every value fits: 64 over 32 is below 2^61.
std::uint64_t Binomial(int n, int k);

/// How many numbers with as many one bits as `number` are smaller (combinatorial number system).
std::uint64_t RankAmongEqualWeight(std::uint64_t number);

/// The number of `bits` bits with `ones` of them set whose RankAmongEqualWeight is `rank`.
/// @pre rank < Binomial(bits, ones).
std::uint64_t NumberOfRank(std::uint64_t rank, int bits, int ones);

/// The bits of `value` at the places of `mask`, closed up, order kept.
std::uint64_t GatherBits(std::uint64_t value, std::uint64_t mask);

/// The lowest bits of `value` spread over the places of `mask`, order kept; the inverse of GatherBits.
std::uint64_t ScatterBits(std::uint64_t value, std::uint64_t mask);

/// The lowest `bits` bits set. @pre 0 ≤ bits ≤ 64.
constexpr std::uint64_t LowestBits(int bits) { return bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1; }

}  // namespace chequer
