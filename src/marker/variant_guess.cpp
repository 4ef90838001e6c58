#include "marker/variant_guess.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "marker/variants.h"

namespace chequer {
namespace {

/// How often a cell is read wrong, and how often a whole kernel is (dirt, a board of another origin).
constexpr double kWrongCell = 0.01, kWrongKernel = 1e-3;
/// Log-likelihood by which another variant must lead: one false alarm in ten thousand.
constexpr double kDecides = 9.2;
/// By which it must lead all others that are not sought either.
constexpr double kLeads = 4.6;

/// How likely an id is, of all that the code has: half as any other, half the more the smaller it is, for people number
/// their markers from 0. Without it, a few small ids of one code could look like another's.
double Prior(const MarkerCode& code, std::uint64_t id) {
  const double ids = static_cast<double>(code.max_id()) + 1, number = static_cast<double>(id) + 1;
  return 0.5 / ids + 0.5 / (number * std::log(ids + 1));
}

/// Log-likelihood of a kernel.
double LogLikelihood(const MarkerCode& code, std::uint64_t kernel) {
  const int bits = KernelBits(code.size());
  // An arbitrary kernel comes from nowhere in particular: one of 2^bits.
  double likelihood = kWrongKernel * std::exp2(-bits);
  if (const auto word = code.DecodeHard(kernel)) {
    const int wrong = word->bits_corrected;
    likelihood += (1 - kWrongKernel) * Prior(code, word->id) * std::pow(kWrongCell, wrong) *
                  std::pow(1 - kWrongCell, bits - wrong);
  }
  return std::log(likelihood);
}

/// Whether both read the same ids from all of them: then it does not matter which it is.
bool ReadAlike(const MarkerCode& one, const MarkerCode& other, const std::set<std::uint64_t>& kernels) {
  return std::all_of(kernels.begin(), kernels.end(), [&](std::uint64_t kernel) {
    const auto first = one.DecodeHard(kernel), second = other.DecodeHard(kernel);
    return first && second && first->id == second->id;
  });
}

double LogLikelihood(const MarkerCode& code, const std::set<std::uint64_t>& kernels) {
  double sum = 0;
  for (const std::uint64_t kernel : kernels) sum += LogLikelihood(code, kernel);
  return sum;
}

}  // namespace

VariantGuess::VariantGuess(const MarkerCode& sought) : sought_(sought) {
  for (const auto& [name, variant] : kVariants) {
    if (variant == Variant::kTable || variant == sought.variant()) continue;
    try {
      others_.emplace_back(sought.size(), variant);
    } catch (const std::runtime_error&) {
      // It does not exist at that size.
    }
  }
}

void VariantGuess::Add(std::uint64_t kernel) {
  if (kernels_.size() < kMostKernels) kernels_.insert(kernel);
}

std::optional<Variant> VariantGuess::LooksLike() const {
  if (kernels_.empty()) return std::nullopt;
  double best = LogLikelihood(sought_, kernels_) + kDecides;
  const MarkerCode* looks_like = nullptr;
  for (const MarkerCode& other : others_) {
    const double likelihood = LogLikelihood(other, kernels_);
    if (likelihood <= best || ReadAlike(sought_, other, kernels_)) continue;
    best = likelihood;
    looks_like = &other;
  }
  if (looks_like == nullptr) return std::nullopt;
  const bool has_rival = std::any_of(others_.begin(), others_.end(), [&](const MarkerCode& other) {
    return &other != looks_like && LogLikelihood(other, kernels_) > best - kLeads &&
           !ReadAlike(*looks_like, other, kernels_);
  });
  return has_rival ? std::nullopt : std::optional(looks_like->variant());
}

}  // namespace chequer
