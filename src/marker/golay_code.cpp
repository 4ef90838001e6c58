#include "marker/golay_code.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "chequer/check.h"
#include "marker/word_list.h"

namespace chequer {
namespace {

constexpr int kWordBits = 24;
constexpr int kDataBits = 12;
constexpr std::uint64_t kWords = 1u << kDataBits;
constexpr int kRadius = 3;
/// x^11 + x^9 + x^7 + x^6 + x^5 + x + 1.
constexpr std::uint64_t kGenerator = 0b101011100011;

/// 12 data bits, 11 bits of the remainder of data · x^11 by the generator, and even parity.
std::uint64_t GolayWord(std::uint64_t data) {
  std::uint64_t remainder = data << 11;
  for (int bit = 22; bit >= 11; --bit) {
    if (remainder >> bit & 1) remainder ^= kGenerator << (bit - 11);
  }
  const std::uint64_t word = (data << 11 | remainder) << 1;
  return word | static_cast<std::uint64_t>(std::popcount(word) & 1);
}

class GolayCode final : public KernelCode {
 public:
  explicit GolayCode(MarkerSize size) : spare_bits_(KernelBits(size) - kWordBits) {
    CHEQUER_CHECK(spare_bits_ >= 0, "too few kernel cells for a Golay word");
    for (std::uint64_t id = 0; id < kWords; ++id) golay_words_.push_back(GolayWord(id));
    min_distance_ = KernelBits(size);
    for (std::uint64_t id = 1; id < kWords; ++id) {  // linear but for a constant: the distances from word 0 are all
      min_distance_ = std::min(min_distance_, std::popcount(Encode(id) ^ Encode(0)));
    }
  }

  std::uint64_t max_id() const override { return kWords - 1; }
  int min_distance() const override { return min_distance_; }
  int guaranteed_radius() const override { return kRadius; }

  std::uint64_t Encode(std::uint64_t id) const override {
    std::uint64_t kernel = golay_words_[id];
    for (int spare = 0; spare < spare_bits_; ++spare) kernel = kernel << 1 | (~id >> DataBitOfSpare(spare) & 1);
    return kernel;
  }

  std::optional<Word> DecodeHard(std::uint64_t kernel) const override {
    // At most one word is near enough in the Golay part alone; the spare cells can only add to its distance.
    const std::optional<std::size_t> id = FindWithin(golay_words_, kernel >> spare_bits_, kRadius);
    if (!id) return std::nullopt;
    const Word word{*id, Encode(*id)};
    if (std::popcount(word.kernel ^ kernel) > kRadius) return std::nullopt;
    return word;
  }

  SoftWord DecodeSoft(const Likelihoods& likelihoods) const override {
    // A spare cell says the opposite of a data cell, so its ratio counts against that cell's; what is left to decode
    // is the Golay word.
    Likelihoods folded;
    folded.bits = kWordBits;
    std::copy_n(likelihoods.ratio.begin() + spare_bits_, kWordBits, folded.ratio.begin());
    for (int spare = 0; spare < spare_bits_; ++spare) {
      const int data_bit = kWordBits - kDataBits + DataBitOfSpare(spare);
      folded.ratio[static_cast<std::size_t>(data_bit)] -=
          likelihoods.ratio[static_cast<std::size_t>(spare_bits_ - 1 - spare)];
    }
    ClassifyBits(folded);
    const std::optional<ListChoice> choice = MostLikely(golay_words_, folded);
    CHEQUER_CHECK(choice.has_value(), "a code without words");
    return {{choice->index, Encode(choice->index)}, choice->margin};
  }

 private:
  /// The data bit (0 the least significant) whose inverse a spare cell shows; the first shows the most significant.
  static int DataBitOfSpare(int spare) { return kDataBits - 1 - spare % kDataBits; }

  int spare_bits_;
  int min_distance_ = 0;
  std::vector<std::uint64_t> golay_words_;  ///< 24 bits each, by id
};

}  // namespace

std::unique_ptr<KernelCode> MakeGolayCode(MarkerSize size) { return std::make_unique<GolayCode>(size); }

}  // namespace chequer
