#pragma once

#include <vector>

#include "marker/kernel_code.h"

namespace chequer {

/// A code of few words, all of them kept: word i is the kernel of id i.
class BlockCode final : public KernelCode {
 public:
  /// @pre the words differ in more than 2 · radius bits.
  BlockCode(std::vector<std::uint64_t> kernels, int bits, int radius);

  std::uint64_t max_id() const override { return kernels_.size() - 1; }
  int min_distance() const override { return min_distance_; }
  int guaranteed_radius() const override { return radius_; }
  std::uint64_t Encode(std::uint64_t id) const override;
  std::optional<Word> DecodeHard(std::uint64_t kernel) const override;
  SoftWord DecodeSoft(const Likelihoods& likelihoods) const override;

 private:
  std::vector<std::uint64_t> kernels_;
  int radius_;
  int min_distance_;
};

}  // namespace chequer
