#include "marker/combinations.h"

#include <array>
#include <bit>
#include <cstddef>

namespace chequer {
namespace {

constexpr std::size_t kRows = 65;

/// Pascal's triangle; entries beyond the diagonal are 0.
constexpr std::array<std::array<std::uint64_t, kRows>, kRows> MakeTriangle() {
  std::array<std::array<std::uint64_t, kRows>, kRows> triangle{};
  for (std::size_t n = 0; n < kRows; ++n) {
    triangle[n][0] = 1;
    for (std::size_t k = 1; k <= n; ++k) triangle[n][k] = triangle[n - 1][k - 1] + triangle[n - 1][k];
  }
  return triangle;
}

constexpr auto kTriangle = MakeTriangle();

}  // namespace

std::uint64_t Binomial(int n, int k) {
  return k > n ? 0 : kTriangle[static_cast<std::size_t>(n)][static_cast<std::size_t>(k)];
}

std::uint64_t RankAmongEqualWeight(std::uint64_t number) {
  std::uint64_t rank = 0;
  for (int k = 1; number != 0; ++k, number &= number - 1) rank += Binomial(std::countr_zero(number), k);
  return rank;
}

std::uint64_t NumberOfRank(std::uint64_t rank, int bits, int ones) {
  std::uint64_t number = 0;
  for (int bit = bits - 1; ones > 0; --bit) {
    // Numbers without this bit come first; there are Binomial(bit, ones) of them.
    const std::uint64_t without = Binomial(bit, ones);
    if (rank < without) continue;
    rank -= without;
    number |= std::uint64_t{1} << bit;
    --ones;
  }
  return number;
}

std::uint64_t GatherBits(std::uint64_t value, std::uint64_t mask) {
  std::uint64_t gathered = 0;
  for (int bit = 0; mask != 0; ++bit, mask &= mask - 1) gathered |= (value >> std::countr_zero(mask) & 1) << bit;
  return gathered;
}

std::uint64_t ScatterBits(std::uint64_t value, std::uint64_t mask) {
  std::uint64_t scattered = 0;
  for (; mask != 0; mask &= mask - 1, value >>= 1) scattered |= (value & 1) << std::countr_zero(mask);
  return scattered;
}

}  // namespace chequer
