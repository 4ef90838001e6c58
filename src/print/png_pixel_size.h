#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace chequer {

/// A PNG that says how large its pixels are (chunk pHYs), so that programs print it in true size; otherwise the same.
/// @pre png is one.
std::vector<std::uint8_t> WithPixelSize(std::span<const std::uint8_t> png, double pixels_per_metre);

}  // namespace chequer
