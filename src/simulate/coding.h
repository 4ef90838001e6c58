#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "chequer/image.h"

namespace chequer {

/// A BGR8 image in another format: RGB8, or any YUV format (BT.601, chroma averaged over the pixels that share it and
/// sited in their middle, as JPEG has it). @pre bgr is BGR8, its size is valid for the format, which is RGB8, BGR8 or
/// YUV.
Image ConvertFromBgr(const ImageView& bgr, PixelFormat format, YuvRange range = YuvRange::kFull);

/// How JPEG shares chroma between pixels.
enum class JpegChroma : std::uint8_t { k444, k422, k420 };

/// JPEG of a BGR8, RGB8 or Mono8 image. Throws std::runtime_error when the codec fails. @pre 1 ≤ quality ≤ 100.
std::vector<std::uint8_t> EncodeJpeg(const ImageView& image, int quality, JpegChroma chroma);

/// What a JPEG holds, as BGR8, RGB8, Mono8, or as the planar YUV format that is stored in it. Throws std::runtime_error
/// where the bytes are not a JPEG, or store chroma in another way than the planar format asked for.
Image DecodeJpeg(std::span<const std::uint8_t> jpeg, PixelFormat format, ToneCurve tone_curve = ToneCurve::Srgb());

}  // namespace chequer
