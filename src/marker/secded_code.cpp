#include "marker/secded_code.h"

#include <algorithm>
#include <array>
#include <bit>

#include "marker/combinations.h"

namespace chequer {
namespace {

constexpr std::size_t kMaxStates = 128;  // 2^7: six parity cells and the overall one at 64 bits
constexpr std::size_t kMaxBits = 64;

/// Column p of the parity check matrix for the cell of Hamming position p; 0 for the overall parity cell, which takes
/// part in the overall check only. The overall check is the lowest bit.
std::size_t Column(int position) { return static_cast<std::size_t>(position) << 1 | 1; }

/// The two cheapest ways to each syndrome over the cells looked at so far, and the last step of the cheapest.
///
/// The cheapest error pattern of a syndrome is a shortest path in the syndrome trellis (Bahl, Cocke, Jelinek, Raviv
/// 1974; Wolf 1978). It is exact for any number of wrong cells, and its cost grows with n · 2^(m + 1), not with the
/// number of words.
class SyndromeTrellis {
 public:
  SyndromeTrellis() {
    best_.fill(std::numeric_limits<double>::infinity());
    second_.fill(std::numeric_limits<double>::infinity());
    best_[0] = 0;
  }

  /// Looks at the next position, from 0 on. Only syndromes of the positions so far can occur, so that early steps are
  /// short.
  void Add(int position, double cost) {
    const std::size_t column = Column(position);
    const std::size_t states = 2 * std::bit_ceil(static_cast<std::size_t>(position) + 1);
    auto& wrong = wrong_[static_cast<std::size_t>(position)];
    for (std::size_t state = 0; state < states; state += 2) {  // the column is odd: partners are even and odd
      const std::size_t partner = state ^ column;
      const double best_a = best_[state], second_a = second_[state];
      const double best_b = best_[partner], second_b = second_[partner];
      wrong[state] = best_b + cost < best_a;
      wrong[partner] = best_a + cost < best_b;
      best_[state] = std::min(best_a, best_b + cost);
      best_[partner] = std::min(best_b, best_a + cost);
      second_[state] = std::min(std::max(best_a, best_b + cost), std::min(second_a, second_b + cost));
      second_[partner] = std::min(std::max(best_b, best_a + cost), std::min(second_b, second_a + cost));
    }
  }

  /// By how much the second way to a syndrome costs more than the first.
  double Margin(std::size_t syndrome) const { return second_[syndrome] - best_[syndrome]; }

  /// The positions, as bits, that are wrong in the cheapest way to a syndrome. @pre positions 0 … positions − 1 added.
  std::uint64_t WrongPositions(std::size_t syndrome, int positions) const {
    std::uint64_t result = 0;
    for (int position = positions - 1; position >= 0; --position) {
      if (!wrong_[static_cast<std::size_t>(position)][syndrome]) continue;
      result |= std::uint64_t{1} << position;
      syndrome ^= Column(position);
    }
    return result;
  }

 private:
  std::array<double, kMaxStates> best_;
  std::array<double, kMaxStates> second_;
  /// Of each position, in the states that Add reaches: whether the cheapest way has the position's cell wrong.
  std::array<std::array<bool, kMaxStates>, kMaxBits> wrong_;
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
    SyndromeTrellis trellis;
    for (int position = 0; position < bits_; ++position) trellis.Add(position, likelihoods.Cost(BitOf(position)));
    const std::size_t syndrome = Syndrome(likelihoods.hard);
    std::uint64_t kernel = likelihoods.hard;
    for (std::uint64_t wrong = trellis.WrongPositions(syndrome, bits_); wrong != 0; wrong &= wrong - 1) {
      kernel ^= PositionBit(std::countr_zero(wrong));
    }
    return {{Id(kernel), kernel}, trellis.Margin(syndrome)};
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
