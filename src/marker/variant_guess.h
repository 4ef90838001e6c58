#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "chequer/marker.h"

namespace chequer {

/// Tells of which variant markers are, from kernels that were read without knowing it. One kernel may be a word of
/// several variants; a dense variant explains any kernel, a sparse one explains a few well: over some markers the
/// likelihood decides.
class VariantGuess {
 public:
  /// All variants that exist at that size, but for tables of one's own. @param sought the variant that is sought.
  explicit VariantGuess(const MarkerCode& sought);

  /// A kernel as its cells were seen. The same one again says nothing new and is passed over; after kMostKernels so is
  /// every other.
  void Add(std::uint64_t kernel);
  void Clear() { kernels_.clear(); }
  std::size_t count() const { return kernels_.size(); }

  /// The variant that explains the kernels so much better than the one that is sought that it decides, and reads other
  /// ids from them; nothing otherwise.
  std::optional<Variant> LooksLike() const;

  static constexpr std::size_t kMostKernels = 256;

 private:
  MarkerCode sought_;
  std::vector<MarkerCode> others_;
  std::set<std::uint64_t> kernels_;
};

}  // namespace chequer
