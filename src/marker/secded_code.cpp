#include "marker/secded_code.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <span>

#include "marker/combinations.h"

namespace chequer {
namespace {

constexpr std::size_t kMaxStates = 128;  // 2^7: six parity cells and the overall one at 64 bits
constexpr std::size_t kMaxBits = 64;

/// Column p of the parity check matrix for the cell of Hamming position p; 0 for the overall parity cell, which takes
/// part in the overall check only. The overall check is the lowest bit.
std::size_t Column(std::size_t position) { return position << 1 | 1; }

/// The syndrome trellis (Bahl, Cocke, Jelinek, Raviv 1974; Wolf 1978), in which error patterns are paths, and the
/// cheapest of a syndrome the shortest: exact for any number of wrong cells, at a cost that grows with n · 2^m, not
/// with the number of words.
class SyndromeTrellis {
 public:
  /// @param costs of errors, by position.
  explicit SyndromeTrellis(std::span<const double> costs) : costs_(costs) {
    cheapest_.fill(std::numeric_limits<double>::infinity());
  }

  /// The positions, as bits, that are wrong in the cheapest way to a syndrome.
  std::uint64_t WrongPositions(std::size_t syndrome) {
    std::array<std::array<bool, kMaxStates>, kMaxBits> wrong;  // whether the cheapest way to a state has the position's
    cheapest_[0] = 0;
    for (std::size_t position = 0; position < costs_.size(); ++position)
      Add(position, [&](std::size_t state, bool is_wrong) { wrong[position][state] = is_wrong; });
    std::uint64_t result = 0;
    for (std::size_t position = costs_.size(); position-- > 0;) {
      if (!wrong[position][syndrome]) continue;
      result |= std::uint64_t{1} << position;
      syndrome ^= Column(position);
    }
    return result;
  }

  /// What the cheapest pattern costs that makes a word another one.
  double ToNextWord() {
    for (std::size_t position = 0; position < costs_.size(); ++position) {
      Add(position, [](std::size_t, bool) {});
      // The first error of a way: ways without any are left out.
      double& alone = cheapest_[Column(position)];
      alone = std::min(alone, costs_[position]);
    }
    return cheapest_[0];
  }

 private:
  /// Looks at the next position, from 0 on. Only syndromes of the positions so far can occur, so that early steps are
  /// short.
  template <class Note>
  void Add(std::size_t position, const Note& note) {
    const std::size_t column = Column(position), states = 2 * std::bit_ceil(position + 1);
    const double cost = costs_[position];
    for (std::size_t state = 0; state < states; state += 2) {  // the column is odd: partners are even and odd
      const std::size_t partner = state ^ column;
      const double a = cheapest_[state], b = cheapest_[partner];
      note(state, b + cost < a);
      note(partner, a + cost < b);
      cheapest_[state] = std::min(a, b + cost);
      cheapest_[partner] = std::min(b, a + cost);
    }
  }

  std::span<const double> costs_;
  std::array<double, kMaxStates> cheapest_;  ///< of the ways to each syndrome over the positions looked at so far
};

class SecdedCode final : public KernelCode {
 public:
  explicit SecdedCode(MarkerSize size) : bits_(KernelBits(size)) {
    for (int position = 1; position < bits_; ++position) {
      if (std::has_single_bit(static_cast<unsigned>(position))) {
        parity_count_++;
      } else {
        data_mask_ |= PositionBit(position);
      }
      for (std::size_t check = 0; check < checks_.size(); ++check) {
        if (position >> check & 1) checks_[check] |= PositionBit(position);
      }
    }
  }

  std::uint64_t max_id() const override { return LowestBits(bits_ - 1 - parity_count_); }
  int min_distance() const override { return max_id() > 0 ? 4 : bits_ + 1; }
  int guaranteed_radius() const override { return 1; }

  std::uint64_t Encode(std::uint64_t id) const override {
    std::uint64_t kernel = FlipOrder(ScatterBits(id, FlipOrder(data_mask_)));
    for (int check = 0; check < parity_count_; ++check) {
      if (IsOdd(kernel & checks_[static_cast<std::size_t>(check)])) kernel |= PositionBit(1 << check);
    }
    if (!IsOdd(kernel)) kernel |= PositionBit(0);
    return kernel;
  }

  std::optional<Word> DecodeHard(std::uint64_t kernel) const override {
    const std::size_t syndrome = Syndrome(kernel);
    if (syndrome == 0) return Word{Id(kernel), kernel};
    if (syndrome % 2 == 0) return std::nullopt;  // an even number of cells is wrong
    const int position = static_cast<int>(syndrome >> 1);
    if (position >= bits_) return std::nullopt;  // a shortened code: no cell has this column
    const std::uint64_t corrected = kernel ^ PositionBit(position);
    return Word{Id(corrected), corrected};
  }

  SoftWord DecodeSoft(const Likelihoods& likelihoods) const override {
    std::array<double, kMaxBits> costs;
    for (int position = 0; position < bits_; ++position)
      costs[static_cast<std::size_t>(position)] = likelihoods.Cost(BitOf(position));
    const std::span<const double> of_positions(costs.data(), static_cast<std::size_t>(bits_));
    const std::size_t syndrome = Syndrome(likelihoods.hard);
    std::uint64_t kernel = likelihoods.hard;
    // A word that was read is the cheapest.
    std::uint64_t wrong = syndrome == 0 ? 0 : SyndromeTrellis(of_positions).WrongPositions(syndrome);
    for (; wrong != 0; wrong &= wrong - 1) {
      const int position = std::countr_zero(wrong);
      kernel ^= PositionBit(position);
      // From the word that was chosen, what was wrong is taken back.
      double& cost = costs[static_cast<std::size_t>(position)];
      cost = -cost;
    }
    return {{Id(kernel), kernel}, std::max(SyndromeTrellis(of_positions).ToNextWord(), 0.0)};
  }

 private:
  static bool IsOdd(std::uint64_t bits) { return std::popcount(bits) % 2 == 1; }

  /// The kernel bit of a Hamming position, 1 … n − 1 for cells 0 … n − 2; position 0 is the overall parity cell n − 1.
  int BitOf(int position) const { return position == 0 ? 0 : bits_ - position; }
  std::uint64_t PositionBit(int position) const { return std::uint64_t{1} << BitOf(position); }

  /// The kernel with its cells in the opposite order, so that positions rise with the weight of bits.
  std::uint64_t FlipOrder(std::uint64_t kernel) const {
    std::uint64_t flipped = 0;
    for (int bit = 0; bit < bits_; ++bit) flipped = flipped << 1 | (kernel >> bit & 1);
    return flipped;
  }

  std::uint64_t Id(std::uint64_t kernel) const { return GatherBits(FlipOrder(kernel), FlipOrder(data_mask_)); }

  /// 0 for a word; the sum of the columns of the wrong cells.
  std::size_t Syndrome(std::uint64_t kernel) const {
    std::size_t syndrome = IsOdd(kernel) ? 0 : 1;
    for (int check = 0; check < parity_count_; ++check) {
      if (IsOdd(kernel & checks_[static_cast<std::size_t>(check)])) syndrome |= std::size_t{2} << check;
    }
    return syndrome;
  }

  int bits_;
  int parity_count_ = 0;                   ///< parity cells but the overall one
  std::uint64_t data_mask_ = 0;            ///< kernel bits of data
  std::array<std::uint64_t, 6> checks_{};  ///< kernel bits that each check sums
};

}  // namespace

std::unique_ptr<KernelCode> MakeSecdedCode(MarkerSize size) { return std::make_unique<SecdedCode>(size); }

}  // namespace chequer
