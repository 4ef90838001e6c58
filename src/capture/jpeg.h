#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "chequer/image.h"

namespace chequer {

/// What to make of a JPEG that stores luma and chroma.
enum class JpegColour : std::uint8_t {
  kBgr,  ///< BGR8
  kYuv,  ///< the planar format that is stored, without any conversion; BGR8 where no PixelFormat matches it
};

/// The image in a JPEG; a JPEG without chroma gives Mono8. EXIF orientation is not applied: pixels stay where the
/// sensor had them. Throws std::runtime_error with the cause if the bytes are not a whole, sound JPEG.
Image ImageFromJpeg(std::span<const std::uint8_t> bytes, JpegColour colour, ToneCurve tone_curve = ToneCurve::Srgb());

/// The same into an image that is used again where its size and format are right, so that nothing is allocated.
/// It is in no particular state when this throws.
void DecodeJpeg(std::span<const std::uint8_t> bytes, JpegColour colour, ToneCurve tone_curve, Image& into);

/// How JPEG shares chroma between pixels.
enum class ChromaSharing : std::uint8_t { k444, k422, k420 };

struct JpegOptions {
  int quality = 90;                            ///< 1..100
  ChromaSharing chroma = ChromaSharing::k420;  ///< of BGR8 and RGB8; planar YUV keeps its own
};

/// Whether JPEG can hold that format: Mono8, BGR8, RGB8, and full-range planar YUV.
bool JpegHolds(PixelFormat format, YuvRange range);

/// A JPEG of an image. @pre JpegHolds its format and range, 1 ≤ quality ≤ 100.
std::vector<std::uint8_t> JpegFromImage(const ImageView& image, const JpegOptions& options = {});

}  // namespace chequer
