#include "marker/block_code.h"

#include <utility>

#include "chequer/check.h"
#include "marker/word_list.h"

namespace chequer {

BlockCode::BlockCode(std::vector<std::uint64_t> kernels, int bits, int radius)
    : kernels_(std::move(kernels)), radius_(radius), min_distance_(MinDistance(kernels_, bits)) {
  CHEQUER_CHECK(min_distance_ > 2 * radius_, "words closer than the decoding radius allows");
}

std::uint64_t BlockCode::Encode(std::uint64_t id) const { return kernels_[id]; }

std::optional<Word> BlockCode::DecodeHard(std::uint64_t kernel) const {
  const std::optional<std::size_t> id = FindWithin(kernels_, kernel, radius_);
  if (!id) return std::nullopt;
  return Word{*id, kernels_[*id]};
}

SoftWord BlockCode::DecodeSoft(const Likelihoods& likelihoods) const {
  const std::optional<ListChoice> choice = MostLikely(kernels_, likelihoods);
  CHEQUER_CHECK(choice.has_value(), "a code without words");
  return {{choice->index, kernels_[choice->index]}, choice->margin};
}

}  // namespace chequer
