#include "marker/word_list.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <vector>

#include "marker/combinations.h"

namespace chequer {
namespace {

constexpr int kByteBits = 8;
constexpr std::size_t kByteValues = 256;

/// Costs of every value of each byte of (kernel xor hard decision).
template <std::size_t kBytes>
class CostTable {
 public:
  explicit CostTable(const Likelihoods& likelihoods) {
    for (std::size_t byte = 0; byte < kBytes; ++byte) {
      std::array<double, kByteValues>& costs = costs_[byte];
      costs[0] = 0;
      for (int bit = 0; bit < kByteBits; ++bit) {
        const std::size_t weight = std::size_t{1} << bit;
        const double cost = likelihoods.Cost(static_cast<int>(byte) * kByteBits + bit);
        for (std::size_t value = 0; value < weight; ++value) costs[weight + value] = costs[value] + cost;
      }
    }
  }

  double Cost(std::uint64_t contradicted) const {
    double cost = 0;
    for (std::size_t byte = 0; byte < kBytes; ++byte) {
      cost += costs_[byte][contradicted >> (byte * kByteBits) & (kByteValues - 1)];
    }
    return cost;
  }

 private:
  std::array<std::array<double, kByteValues>, kBytes> costs_;
};

template <std::size_t kBytes>
ListChoice MostLikelyOfBytes(std::span<const std::uint64_t> kernels, const Likelihoods& likelihoods) {
  const CostTable<kBytes> table(likelihoods);
  ListChoice choice;
  double best = std::numeric_limits<double>::infinity();
  double second = best;
  for (std::size_t i = 0; i < kernels.size(); ++i) {
    const double cost = table.Cost(kernels[i] ^ likelihoods.hard);
    if (cost >= second) continue;
    if (cost < best) {
      second = best;
      best = cost;
      choice.index = i;
    } else {
      second = cost;
    }
  }
  choice.margin = second - best;
  return choice;
}

/// Whether two kernels that agree in all bits of `block` differ in at most `distance` bits.
/// Sorts the kernels by the block.
bool HasClosePair(std::vector<std::uint64_t>& kernels, std::uint64_t block, int distance) {
  std::sort(kernels.begin(), kernels.end(),
            [block](std::uint64_t a, std::uint64_t b) { return (a & block) < (b & block); });
  for (std::size_t i = 0; i < kernels.size(); ++i) {
    for (std::size_t j = i + 1; j < kernels.size() && ((kernels[i] ^ kernels[j]) & block) == 0; ++j) {
      if (std::popcount(kernels[i] ^ kernels[j]) <= distance) return true;
    }
  }
  return false;
}

}  // namespace

std::optional<ListChoice> MostLikely(std::span<const std::uint64_t> kernels, const Likelihoods& likelihoods) {
  if (kernels.empty()) return std::nullopt;
  switch ((likelihoods.bits + kByteBits - 1) / kByteBits) {
    case 1: return MostLikelyOfBytes<1>(kernels, likelihoods);
    case 2: return MostLikelyOfBytes<2>(kernels, likelihoods);
    case 3: return MostLikelyOfBytes<3>(kernels, likelihoods);
    case 4: return MostLikelyOfBytes<4>(kernels, likelihoods);
    case 5: return MostLikelyOfBytes<5>(kernels, likelihoods);
    case 6: return MostLikelyOfBytes<6>(kernels, likelihoods);
    case 7: return MostLikelyOfBytes<7>(kernels, likelihoods);
    default: return MostLikelyOfBytes<8>(kernels, likelihoods);
  }
}

std::optional<std::size_t> FindWithin(std::span<const std::uint64_t> kernels, std::uint64_t kernel, int radius) {
  for (std::size_t i = 0; i < kernels.size(); ++i) {
    if (std::popcount(kernels[i] ^ kernel) <= radius) return i;
  }
  return std::nullopt;
}

int MinDistance(std::span<const std::uint64_t> kernels, int bits) {
  // Two kernels at distance d agree in at least one of any d + 1 blocks of bits, so only pairs that share a block need
  // to be compared: all pairs of 65 536 kernels would take seconds.
  std::vector<std::uint64_t> sorted(kernels.begin(), kernels.end());
  if (sorted.size() < 2) return bits + 1;
  for (int distance = 0; distance < bits; ++distance) {
    for (int block = 0; block <= distance; ++block) {
      const int begin = bits * block / (distance + 1);
      const int end = bits * (block + 1) / (distance + 1);
      if (HasClosePair(sorted, LowestBits(end) & ~LowestBits(begin), distance)) return distance;
    }
  }
  return bits;
}

}  // namespace chequer
