#include "marker/table_code.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "chequer/check.h"
#include "marker/combinations.h"
#include "marker/word_list.h"

namespace chequer {
namespace {

class TableCode final : public KernelCode {
 public:
  TableCode(std::vector<std::uint64_t> kernels, std::vector<Word> by_kernel, int bits)
      : kernels_(std::move(kernels)), by_kernel_(std::move(by_kernel)), bits_(bits) {}

  std::uint64_t max_id() const override { return kernels_.size() - 1; }
  int min_distance() const override { return MinDistance(kernels_, bits_); }
  std::uint64_t Encode(std::uint64_t id) const override { return kernels_[id]; }

  std::optional<Word> DecodeHard(std::uint64_t kernel) const override {
    const auto it = std::lower_bound(by_kernel_.begin(), by_kernel_.end(), kernel,
                                     [](const Word& word, std::uint64_t value) { return word.kernel < value; });
    if (it == by_kernel_.end() || it->kernel != kernel) return std::nullopt;
    return *it;
  }

  SoftWord DecodeSoft(const Likelihoods& likelihoods) const override {
    const std::optional<ListChoice> choice = MostLikely(kernels_, likelihoods);
    CHEQUER_CHECK(choice.has_value(), "a code without words");
    return {{choice->index, kernels_[choice->index]}, choice->margin};
  }

 private:
  std::vector<std::uint64_t> kernels_;  ///< by id
  std::vector<Word> by_kernel_;         ///< ascending by kernel
  int bits_;
};

}  // namespace

std::unique_ptr<KernelCode> MakeTableCode(MarkerSize size, std::vector<std::uint64_t> kernels,
                                          std::span<const std::string> entry_names) {
  const auto name = [entry_names](std::uint64_t id) {
    return entry_names.empty() ? "entry " + std::to_string(id) : entry_names[id];
  };
  if (kernels.empty()) throw std::runtime_error("the table of kernels is empty; it needs at least one entry");
  if (kernels.size() > kMaxTableEntries) {
    throw std::runtime_error("the table of kernels has " + std::to_string(kernels.size()) + " entries; at most " +
                             std::to_string(kMaxTableEntries) + " are allowed");
  }
  const int bits = KernelBits(size);
  std::vector<Word> by_kernel;
  by_kernel.reserve(kernels.size());
  for (std::uint64_t id = 0; id < kernels.size(); ++id) {
    if ((kernels[id] & ~LowestBits(bits)) != 0) {
      throw std::runtime_error(name(id) + " of the table of kernels has bits beyond the " + std::to_string(bits) +
                               " kernel cells of a " + ToString(size) + " marker");
    }
    by_kernel.push_back({id, kernels[id]});
  }
  std::stable_sort(by_kernel.begin(), by_kernel.end(),
                   [](const Word& a, const Word& b) { return a.kernel < b.kernel; });
  const auto twin = std::adjacent_find(by_kernel.begin(), by_kernel.end(),
                                       [](const Word& a, const Word& b) { return a.kernel == b.kernel; });
  if (twin != by_kernel.end()) {
    throw std::runtime_error(name(twin->id) + " and " + name((twin + 1)->id) +
                             " of the table of kernels are equal; every id needs a kernel of its own");
  }
  return std::make_unique<TableCode>(std::move(kernels), std::move(by_kernel), bits);
}

}  // namespace chequer
