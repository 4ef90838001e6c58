#pragma once

#include <hwy/targets.h>

#include <cstdint>
#include <vector>

namespace chequer::test {

/// The instruction sets that this build and processor have, each for hwy::SetSupportedTargetsForTest.
inline std::vector<std::int64_t> AllTargets() {
  std::vector<std::int64_t> targets;
  for (auto left = static_cast<std::uint64_t>(hwy::SupportedTargets()); left != 0; left &= left - 1)
    targets.push_back(static_cast<std::int64_t>(left & ~(left - 1)));
  return targets;
}

}  // namespace chequer::test
