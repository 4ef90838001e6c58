#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "chequer/image.h"

namespace chequer {

/// The image in a PNG: BGR8, or Mono8 where there is one channel. Transparency is dropped, values are taken as they are
/// whatever curve the file names. Throws std::runtime_error with the cause if the bytes are not a whole, sound PNG of
/// at most 8 bits a sample.
Image ImageFromPng(std::span<const std::uint8_t> bytes, ToneCurve tone_curve = ToneCurve::Srgb());

/// Whether PNG can hold that format: BGR8, and the formats of one channel.
bool PngHolds(PixelFormat format);

/// A PNG of an image; one-channel formats become a grey PNG. Packed quickly rather than tightly. @pre PngHolds its
/// format.
std::vector<std::uint8_t> PngFromImage(const ImageView& image);

}  // namespace chequer
