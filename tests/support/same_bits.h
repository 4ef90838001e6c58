#pragma once

#include <string>
#include <vector>

#include "chequer/detector.h"

namespace chequer::test {

/// What a detector says of an image.
struct Detected {
  std::vector<MarkerPose> markers;
  DetectStats stats;
};

/// Empty where both are the same to the last bit, so that a NaN equals itself and 0 is not −0; else what differs first,
/// and how.
std::string DifferenceOf(const Detected& expected, const Detected& actual);

}  // namespace chequer::test
