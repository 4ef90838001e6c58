#include "marker/constrained_code.h"

#include <algorithm>
#include <bit>

#include "marker/combinations.h"

namespace chequer {
namespace {

class UnconstrainedCode final : public KernelCode {
 public:
  explicit UnconstrainedCode(MarkerSize size) : bits_(KernelBits(size)) {}

  std::uint64_t max_id() const override { return LowestBits(bits_); }
  int min_distance() const override { return 1; }
  std::uint64_t Encode(std::uint64_t id) const override { return id; }
  std::optional<Word> DecodeHard(std::uint64_t kernel) const override { return Word{kernel, kernel}; }

  SoftWord DecodeSoft(const Likelihoods& likelihoods) const override {
    SoftWord result{{likelihoods.hard, likelihoods.hard}};
    // The second best word differs in the least certain cell.
    for (int bit = 0; bit < bits_; ++bit) result.margin = std::min(result.margin, likelihoods.Cost(bit));
    return result;
  }

 private:
  int bits_;
};

/// Cells of which half, rounded down, are saturated.
struct BalancedClass {
  explicit BalancedClass(std::uint64_t class_mask)
      : mask(class_mask), bits(std::popcount(class_mask)), ones(bits / 2), words(Binomial(bits, ones)) {}

  std::uint64_t mask;  ///< the class's bits of the kernel
  int bits;
  int ones;  ///< saturated cells
  std::uint64_t words;

  bool Holds(std::uint64_t kernel) const { return std::popcount(kernel & mask) == ones; }
  std::uint64_t Rank(std::uint64_t kernel) const { return RankAmongEqualWeight(GatherBits(kernel, mask)); }
  std::uint64_t Kernel(std::uint64_t rank) const { return ScatterBits(NumberOfRank(rank, bits, ones), mask); }
};

struct BalancedChoice {
  std::uint64_t kernel = 0;
  double margin = std::numeric_limits<double>::infinity();
};

/// The class's most likely bits: those with the `ones` largest ratios. The second best choice swaps the least likely
/// chosen bit for the most likely one left out.
BalancedChoice MostLikely(const BalancedClass& cells, const Likelihoods& likelihoods) {
  struct Candidate {
    double ratio;
    int bit;
  };
  std::array<Candidate, 64> candidates;
  auto end = candidates.begin();
  for (std::uint64_t left = cells.mask; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    *end++ = {likelihoods.ratio[static_cast<std::size_t>(bit)], bit};
  }
  const auto boundary = candidates.begin() + cells.ones;
  const auto more_likely = [](const Candidate& a, const Candidate& b) { return a.ratio > b.ratio; };
  std::nth_element(candidates.begin(), boundary, end, more_likely);

  BalancedChoice choice;
  for (auto it = candidates.begin(); it != boundary; ++it) choice.kernel |= std::uint64_t{1} << it->bit;
  if (cells.ones > 0) {  // then there is also a bit left out, for ones is at most half the bits
    const auto least_chosen = std::max_element(candidates.begin(), boundary, more_likely);
    choice.margin = least_chosen->ratio - boundary->ratio;
  }
  return choice;
}

class SaturationConstrainedCode final : public KernelCode {
 public:
  explicit SaturationConstrainedCode(MarkerSize size) : all_(LowestBits(KernelBits(size))) {}

  std::uint64_t max_id() const override { return all_.words - 1; }
  int min_distance() const override { return all_.words > 1 ? 2 : all_.bits + 1; }
  std::uint64_t Encode(std::uint64_t id) const override { return all_.Kernel(id); }
  std::optional<Word> DecodeHard(std::uint64_t kernel) const override {
    if (!all_.Holds(kernel)) return std::nullopt;
    return Word{RankAmongEqualWeight(kernel), kernel};
  }
  SoftWord DecodeSoft(const Likelihoods& likelihoods) const override {
    const BalancedChoice choice = MostLikely(all_, likelihoods);
    return {{RankAmongEqualWeight(choice.kernel), choice.kernel}, choice.margin};
  }

 private:
  BalancedClass all_;
};

class ColorConstrainedCode final : public KernelCode {
 public:
  explicit ColorConstrainedCode(MarkerSize size)
      : dark_(DarkKernelBits(size)), light_(LowestBits(KernelBits(size)) & ~DarkKernelBits(size)) {}

  // At most (32 over 16)², below 2^59.
  std::uint64_t max_id() const override { return dark_.words * light_.words - 1; }
  int min_distance() const override { return max_id() > 0 ? 2 : dark_.bits + light_.bits + 1; }
  std::uint64_t Encode(std::uint64_t id) const override {
    return dark_.Kernel(id / light_.words) | light_.Kernel(id % light_.words);
  }
  std::optional<Word> DecodeHard(std::uint64_t kernel) const override {
    if (!dark_.Holds(kernel) || !light_.Holds(kernel)) return std::nullopt;
    return Word{Id(kernel), kernel};
  }
  SoftWord DecodeSoft(const Likelihoods& likelihoods) const override {
    const BalancedChoice dark = MostLikely(dark_, likelihoods);
    const BalancedChoice light = MostLikely(light_, likelihoods);
    const std::uint64_t kernel = dark.kernel | light.kernel;
    return {{Id(kernel), kernel}, std::min(dark.margin, light.margin)};
  }

 private:
  std::uint64_t Id(std::uint64_t kernel) const { return dark_.Rank(kernel) * light_.words + light_.Rank(kernel); }

  BalancedClass dark_;
  BalancedClass light_;
};

}  // namespace

std::uint64_t DarkKernelBits(MarkerSize size) {
  std::uint64_t dark = 0;
  for (int row = 1; row < size.rows - 1; ++row) {
    for (int col = 1; col < size.cols - 1; ++col) dark = dark << 1 | std::uint64_t{IsDark(row, col)};
  }
  return dark;
}

std::unique_ptr<KernelCode> MakeUnconstrainedCode(MarkerSize size) { return std::make_unique<UnconstrainedCode>(size); }

std::unique_ptr<KernelCode> MakeSaturationConstrainedCode(MarkerSize size) {
  return std::make_unique<SaturationConstrainedCode>(size);
}

std::unique_ptr<KernelCode> MakeColorConstrainedCode(MarkerSize size) {
  return std::make_unique<ColorConstrainedCode>(size);
}

}  // namespace chequer
