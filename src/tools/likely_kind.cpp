#include "tools/likely_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "marker/variant_guess.h"
#include "marker/variants.h"
#include "tools/any_boards.h"

namespace chequer {
namespace {

std::optional<MarkerCode> CodeOf(MarkerSize size, Variant variant) {
  if (variant == Variant::kTable) return std::nullopt;  // of one's own: unknown here
  try {
    return MarkerCode(size, variant);
  } catch (const std::runtime_error&) {
    return std::nullopt;  // it does not exist at that size
  }
}

int CountWords(const MarkerCode& code, const std::vector<std::uint64_t>& kernels) {
  return static_cast<int>(std::count_if(kernels.begin(), kernels.end(), [&](std::uint64_t kernel) {
    const auto word = code.DecodeHard(kernel);
    return word && word->bits_corrected == 0;
  }));
}

/// The variant that the kernels are words of: secded unless another explains them far better.
Variant GuessVariant(MarkerSize size, const std::vector<std::uint64_t>& kernels) {
  const auto usual = CodeOf(size, Variant::kSecded);
  const MarkerCode start = usual ? *usual : MarkerCode(size, Variant::kUnconstrained);
  VariantGuess guess(start);
  for (const std::uint64_t kernel : kernels) guess.Add(kernel);
  if (const auto better = guess.LooksLike()) return *better;
  if (CountWords(start, kernels) > 0) return start.variant();
  // Too few to be sure: the one of which most are words, the sparsest first.
  Variant best = Variant::kUnconstrained;
  int most = 0;
  std::uint64_t fewest_ids = 0;
  for (const auto& [name, variant] : kVariants) {
    const auto code = CodeOf(size, variant);
    if (!code) continue;
    const int words = CountWords(*code, kernels);
    if (words < most || (words == most && most > 0 && code->max_id() >= fewest_ids) || words == 0) continue;
    best = variant;
    most = words;
    fewest_ids = code->max_id();
  }
  return best;
}

}  // namespace

std::string LikelyKind::Text() const {
  return fmt::format("{} {} ({} of {} board{})", ToString(size), VariantName(variant), words, boards,
                     boards == 1 ? "" : "s");
}

std::string LikelyKind::Option() const { return fmt::format("{}:{}", ToString(size), VariantName(variant)); }

std::optional<LikelyKind> GuessKind(const ImageView& image, const DetectorOptions& sought) {
  std::map<std::pair<int, int>, std::vector<AnyBoard>> by_size;
  for (const AnyBoard& board : FindAnyBoards(image, sought, false))
    by_size[{board.size.rows, board.size.cols}].push_back(board);
  if (by_size.empty()) return std::nullopt;
  const auto most = std::max_element(by_size.begin(), by_size.end(), [](const auto& one, const auto& other) {
    return one.second.size() < other.second.size();
  });
  std::vector<std::uint64_t> kernels;
  for (const AnyBoard& board : most->second)
    if (board.kernel) kernels.push_back(*board.kernel);
  LikelyKind likely{.size = most->second.front().size, .boards = static_cast<int>(most->second.size())};
  likely.variant = GuessVariant(likely.size, kernels);
  if (const auto code = CodeOf(likely.size, likely.variant)) likely.words = CountWords(*code, kernels);
  return likely;
}

}  // namespace chequer
