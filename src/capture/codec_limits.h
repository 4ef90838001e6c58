#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "chequer/image.h"

namespace chequer {

/// Most pixels of an image file: a few kilobytes can promise gigabytes.
inline constexpr std::int64_t kMaxFilePixels = std::int64_t{1} << 27;

/// Throws std::runtime_error where a header promises a size that no image here can have.
inline void CheckPromisedSize(std::int64_t width, std::int64_t height) {
  const bool fits = width >= 1 && height >= 1 && width <= kMaxImageSide && height <= kMaxImageSide;
  if (fits && width * height <= kMaxFilePixels) return;
  throw std::runtime_error("it says it has " + std::to_string(width) + " x " + std::to_string(height) +
                           " pixels; allowed are sides from 1 to " + std::to_string(kMaxImageSide) + " and " +
                           std::to_string(kMaxFilePixels) + " pixels in all");
}

}  // namespace chequer
