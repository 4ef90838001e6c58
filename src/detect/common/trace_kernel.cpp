#include "detect/common/trace_kernel.h"

#include <cmath>

namespace chequer {
namespace {

/// A cell is wrong once in a thousand times at that log-likelihood (ln 1000 = 6.9).
constexpr float kSure = 7;

}  // namespace

std::optional<std::uint64_t> KernelOf(const TraceCandidate& candidate) {
  const Refusal refusal = candidate.refusal;
  const bool was_read = refusal == Refusal::kNone || refusal == Refusal::kNoWord || refusal == Refusal::kTwoWords;
  if (!was_read || candidate.marker < 0 || !candidate.CameFar()) return std::nullopt;
  std::uint64_t kernel = 0;
  for (const TraceCell& cell : candidate.cells) {
    if (IsBorder(candidate.size, cell.at.row, cell.at.col)) continue;
    if (!cell.seen || std::abs(cell.log_likelihood) < kSure) return std::nullopt;
    kernel = kernel << 1 | (cell.log_likelihood > 0 ? 1u : 0u);
  }
  return kernel;
}

}  // namespace chequer
