#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "detect/corner.h"
#include "detect/corner_response.h"
#include "detect/plane.h"

namespace chequer {

/// Appends to `corners`, in the order of the peaks, those around which the plane changes between light and dark
/// exactly four times, with opposite edges in line (to 43 degrees), and whose response is not too weak for their
/// contrast. Positions are pixels of the plane, to the peak of the response; scales are 1.
/// 20 ns a peak, with AVX-512.
/// @pre every peak lies at least kRingMargin inside the plane.
/// @param refused if given, is replaced by the indices of the other peaks.
void AppendSaddles(const BytePlane& plane, std::span<const Peak> peaks, std::vector<Corner>& corners,
                   std::vector<std::size_t>* refused = nullptr);

}  // namespace chequer
