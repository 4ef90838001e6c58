#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "chequer/image.h"

namespace chequer {

/// The image in a binary PGM (P5, gives Mono8) or PPM (P6, gives BGR8). Throws std::runtime_error with the cause if the
/// bytes are not a whole one with values up to 255.
Image ImageFromPnm(std::span<const std::uint8_t> bytes, ToneCurve tone_curve = ToneCurve::Srgb());

/// The image in an uncompressed BMP of 24 or 32 bits a pixel (BGR8), or of 8 (BGR8, or Mono8 where its palette is the
/// grey scale). Throws std::runtime_error with the cause on anything else.
Image ImageFromBmp(std::span<const std::uint8_t> bytes, ToneCurve tone_curve = ToneCurve::Srgb());

}  // namespace chequer
