#pragma once

#include <cstdint>
#include <vector>

#include "detect/plane.h"

namespace chequer {

/// A local maximum of the corner response, in whole pixels of its plane.
struct Peak {
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  std::uint8_t response = 0;
};

/// How many pixels from the plane's edge no response is computed.
inline constexpr int kRingMargin = 3;

/// Fills `response` (same size as `plane`) with how much each pixel looks like the corner of four cells, in grey levels
/// from 0 to about half the contrast. One ring of 12 pixels at radius 3.2 serves cells from 4 to 60 px on sharp images;
/// blurred ones are sharp on a smaller plane. The test is that of ChESS (Bennett and Lasenby, 2014) on that ring:
/// sums of opposite pixels that differ from those a quarter turn on, less the differences of opposite pixels, less the
/// difference of the ring's mean and the centre.
void CornerResponse(const BytePlane& plane, BytePlane& response);

/// Appends the pixels of at least `threshold` that no neighbour of the 3 × 3 exceeds, row by row.
void FindPeaks(const BytePlane& response, std::uint8_t threshold, std::vector<Peak>& peaks);

}  // namespace chequer
