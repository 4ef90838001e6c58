#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "chequer/detector.h"
#include "chequer/image.h"

namespace chequer {

/// The image with what was read drawn in: each board's outline, green where it was read and amber where its id is
/// open, an arrow along its x axis, and its id. A PNG that fits a screen: at most 1280 pixels wide, smaller images up
/// to twice as large. Throws std::runtime_error where drawing fails.
/// @param image BGR8.
std::vector<std::uint8_t> DrawDetection(const ImageView& image, std::span<const MarkerPose> markers);

}  // namespace chequer
