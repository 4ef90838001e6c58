#include <algorithm>
#include <utility>

#include "chequer/check.h"
#include "chequer/marker.h"
#include "marker/word_list.h"

namespace chequer {

Roster::Roster(std::vector<std::uint64_t> ids) : ids_(std::move(ids)) {
  std::sort(ids_.begin(), ids_.end());
  ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
}

bool Roster::Contains(std::uint64_t id) const { return std::binary_search(ids_.begin(), ids_.end(), id); }

RosterDecoder::RosterDecoder(const MarkerCode& code, const Roster& roster) : bits_(KernelBits(code.size())) {
  const auto end = std::upper_bound(roster.ids().begin(), roster.ids().end(), code.max_id());
  ids_.assign(roster.ids().begin(), end);
  kernels_.reserve(ids_.size());
  for (const std::uint64_t id : ids_) kernels_.push_back(code.Encode(id));
}

std::optional<SoftDecoded> RosterDecoder::DecodeSoft(std::span<const float> log_likelihood_ratio) const {
  CHEQUER_CHECK(log_likelihood_ratio.size() == static_cast<std::size_t>(bits_), "one ratio a kernel cell is needed");
  const Likelihoods likelihoods = LikelihoodsOfCells(log_likelihood_ratio);
  const std::optional<ListChoice> choice = MostLikely(kernels_, likelihoods);
  if (!choice) return std::nullopt;
  const std::uint64_t kernel = kernels_[choice->index];
  return SoftDecoded{{ids_[choice->index], kernel, CountContradicted(likelihoods, kernel)}, choice->margin};
}

}  // namespace chequer
