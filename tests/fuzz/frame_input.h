#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "chequer/image.h"

namespace chequer::fuzz {

/// A frame of any format over arbitrary bytes: the first names the format, the second and third the size, the fourth
/// range and tone curve, the rest is pixels. Nothing where they do not suffice.
inline std::optional<ImageView> FrameOf(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHeader = 4;
  constexpr int kFormats = static_cast<int>(PixelFormat::kYuv444p) + 1;
  if (size < kHeader) return std::nullopt;
  const auto format = static_cast<PixelFormat>(data[0] % kFormats);
  const YuvRange range = (data[3] & 1) != 0 ? YuvRange::kLimited : YuvRange::kFull;
  const ToneCurve curve = (data[3] & 2) != 0 ? ToneCurve::Linear() : ToneCurve::Srgb();
  return ViewPacked(format, data[1], data[2], std::span(data, size).subspan(kHeader), curve, range);
}

}  // namespace chequer::fuzz
