#pragma once

#include <cstdint>
#include <vector>

#include "detect/common/plane.h"

namespace chequer {

/// Widest running mean, px.
inline constexpr int kWidestMean = 15;

/// Smoothes rows by two running means of `width` values each, which have a variance of (width² − 1) / 6 px² together;
/// beyond its ends, a row goes on as it ends. @param width odd, 3 to kWidestMean. @param scratch keeps its memory.
void SmoothRows(int width, BytePlane& plane, std::vector<std::uint8_t>& scratch);

}  // namespace chequer
