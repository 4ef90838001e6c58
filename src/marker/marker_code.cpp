#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <stdexcept>
#include <utility>

#include "chequer/check.h"
#include "chequer/marker.h"
#include "marker/combinations.h"
#include "marker/constrained_code.h"
#include "marker/golay_code.h"
#include "marker/kernel_code.h"
#include "marker/quadratic_codes.h"
#include "marker/secded_code.h"
#include "marker/table_code.h"
#include "marker/table_file.h"
#include "marker/variants.h"

namespace chequer {
namespace {

constexpr int kGolayBits = 24;
constexpr int kQuadraticBits = 16;

void CheckSize(MarkerSize size) {
  if (IsValid(size)) return;
  throw std::runtime_error("a marker of " + ToString(size) +
                           " cells does not exist; rows and columns must be at least 3 and the inner (rows - 2) x "
                           "(columns - 2) cells at most 64");
}

void RequireBits(MarkerSize size, Variant variant, bool fits, std::string_view needed) {
  if (fits) return;
  throw std::runtime_error("the variant " + std::string(VariantName(variant)) + " needs " + std::string(needed) +
                           "; a " + ToString(size) + " marker has " + std::to_string(KernelBits(size)));
}

std::unique_ptr<KernelCode> MakeKernelCode(MarkerSize size, Variant variant) {
  CheckSize(size);
  const int bits = KernelBits(size);
  switch (variant) {
    case Variant::kUnconstrained: return MakeUnconstrainedCode(size);
    case Variant::kSaturationConstrained: return MakeSaturationConstrainedCode(size);
    case Variant::kColorConstrained: return MakeColorConstrainedCode(size);
    case Variant::kSecded: return MakeSecdedCode(size);
    case Variant::kGolay:
      RequireBits(size, variant, bits >= kGolayBits, "at least 24 kernel cells (such as 8x8)");
      return MakeGolayCode(size);
    case Variant::kNordstromRobinson:
      RequireBits(size, variant, bits == kQuadraticBits, "exactly 16 kernel cells (such as 6x6)");
      return MakeNordstromRobinsonCode();
    case Variant::kReedMuller:
      RequireBits(size, variant, bits == kQuadraticBits, "exactly 16 kernel cells (such as 6x6)");
      return MakeReedMullerCode();
    case Variant::kTable: break;
  }
  throw std::runtime_error("the variant table needs its kernels, from a file or a list");
}

/// The most likely word of the ids of a roster; nothing where the code has none of them.
std::optional<SoftWord> MostLikelyOfRoster(const KernelCode& code, const Roster& roster,
                                           const Likelihoods& likelihoods) {
  std::optional<SoftWord> result;
  double best = std::numeric_limits<double>::infinity();
  double second = best;
  for (const std::uint64_t id : roster.ids()) {
    if (id > code.max_id()) break;  // they ascend
    const std::uint64_t kernel = code.Encode(id);
    const double cost = CostOf(likelihoods, kernel);
    if (!result || cost < best) {
      second = std::exchange(best, cost);
      result = SoftWord{{id, kernel}};
    } else {
      second = std::min(second, cost);
    }
  }
  if (result) result->margin = second - best;
  return result;
}

}  // namespace

std::string_view VariantName(Variant variant) {
  const auto index = static_cast<std::size_t>(variant);
  return index < kVariants.size() ? kVariants[index].first : "unknown";
}

std::optional<Variant> ParseVariant(std::string_view name) {
  for (const auto& [known, variant] : kVariants)
    if (known == name) return variant;
  return std::nullopt;
}

struct MarkerCode::Impl {
  MarkerSize size;
  Variant variant;
  std::unique_ptr<const KernelCode> code;
};

MarkerCode::MarkerCode(MarkerSize size, Variant variant)
    : MarkerCode(std::make_shared<const Impl>(Impl{size, variant, MakeKernelCode(size, variant)})) {}

MarkerCode::MarkerCode(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

MarkerCode MarkerCode::FromTable(MarkerSize size, std::vector<std::uint64_t> kernels) {
  CheckSize(size);
  return MarkerCode(std::make_shared<const Impl>(Impl{size, Variant::kTable, MakeTableCode(size, std::move(kernels))}));
}

MarkerCode MarkerCode::LoadTable(MarkerSize size, const std::filesystem::path& path) {
  CheckSize(size);
  TableFile table = ReadTableFile(size, path);
  try {
    std::unique_ptr<KernelCode> code = MakeTableCode(size, std::move(table.kernels), table.places);
    return MarkerCode(std::make_shared<const Impl>(Impl{size, Variant::kTable, std::move(code)}));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path.string() + ": " + error.what());
  }
}

MarkerSize MarkerCode::size() const { return impl_->size; }
Variant MarkerCode::variant() const { return impl_->variant; }
std::uint64_t MarkerCode::max_id() const { return impl_->code->max_id(); }
int MarkerCode::min_distance() const { return impl_->code->min_distance(); }
int MarkerCode::guaranteed_radius() const { return impl_->code->guaranteed_radius(); }

std::uint64_t MarkerCode::Encode(std::uint64_t id) const {
  CHEQUER_CHECK(id <= max_id(), "no such id in this variant at this size");
  return impl_->code->Encode(id);
}

std::optional<Decoded> MarkerCode::DecodeHard(std::uint64_t kernel) const {
  if ((kernel & ~LowestBits(KernelBits(impl_->size))) != 0) return std::nullopt;
  const std::optional<Word> word = impl_->code->DecodeHard(kernel);
  if (!word) return std::nullopt;
  return Decoded{word->id, word->kernel, std::popcount(word->kernel ^ kernel)};
}

std::optional<SoftDecoded> MarkerCode::DecodeSoft(std::span<const float> log_likelihood_ratio,
                                                  const Roster* roster) const {
  CHEQUER_CHECK(log_likelihood_ratio.size() == static_cast<std::size_t>(KernelBits(impl_->size)),
                "one ratio a kernel cell is needed");
  const Likelihoods likelihoods = LikelihoodsOfCells(log_likelihood_ratio);
  const std::optional<SoftWord> best =
      roster == nullptr ? impl_->code->DecodeSoft(likelihoods) : MostLikelyOfRoster(*impl_->code, *roster, likelihoods);
  if (!best) return std::nullopt;
  const int corrected = CountContradicted(likelihoods, best->word.kernel);
  return SoftDecoded{{best->word.id, best->word.kernel, corrected}, best->margin};
}

}  // namespace chequer
