#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "marker/likelihoods.h"

namespace chequer {

/// A word of a code: an id and its kernel.
struct Word {
  std::uint64_t id = 0;
  std::uint64_t kernel = 0;
};

/// The most likely word of a code.
struct SoftWord {
  Word word;
  double margin = std::numeric_limits<double>::infinity();  ///< log-likelihood ratio over the second best, ≥ 0
};

/// A rule that maps ids to kernels and back, at one size. Immutable, any thread.
class KernelCode {
 public:
  KernelCode() = default;
  KernelCode(const KernelCode&) = delete;
  KernelCode& operator=(const KernelCode&) = delete;
  virtual ~KernelCode() = default;

  virtual std::uint64_t max_id() const = 0;
  /// The least number of cells in which two words differ; kernel cells + 1 where there is one word only.
  virtual int min_distance() const = 0;
  virtual int guaranteed_radius() const { return 0; }
  /// @pre id ≤ max_id().
  virtual std::uint64_t Encode(std::uint64_t id) const = 0;
  /// The word within the guaranteed radius. @pre no bits of `kernel` beyond the kernel's.
  virtual std::optional<Word> DecodeHard(std::uint64_t kernel) const = 0;
  /// The most likely of all words. Allocates nothing.
  virtual SoftWord DecodeSoft(const Likelihoods& likelihoods) const = 0;
};

}  // namespace chequer
