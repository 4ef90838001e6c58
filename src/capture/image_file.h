#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "capture/jpeg.h"
#include "chequer/image.h"

namespace chequer {

/// The largest image file that is read, bytes.
inline constexpr std::size_t kMaxImageFileBytes = std::size_t{1} << 30;

/// What a file does not say itself.
struct ImageFileOptions {
  /// What the one channel of a grey file holds: kMono8 or a Bayer format.
  PixelFormat one_channel = PixelFormat::kMono8;
  JpegColour jpeg_colour = JpegColour::kBgr;
  ToneCurve tone_curve = ToneCurve::Srgb();
};

/// The image in a PNG, JPEG, PGM, PPM or BMP file, told apart by its first bytes: BGR8, planar YUV (JPEG, if asked for)
/// or, where it has one channel, the stated format. The orientation that EXIF may name is not applied: pixels stay
/// where the sensor had them, which is what calibrations and Bayer phases are about. Throws std::runtime_error naming
/// the file and the cause: missing, not permitted, not an image, truncated, damaged, 16 bits a sample, too large. A
/// file that is not whole never gives part of an image.
/// @pre one_channel is kMono8 or Bayer.
Image LoadImage(const std::filesystem::path& path, const ImageFileOptions& options = {});

/// The same from bytes; the messages then do not begin with a name.
Image DecodeImage(std::span<const std::uint8_t> bytes, const ImageFileOptions& options = {});

/// How the packed bytes of a file without header are laid out.
struct RawLayout {
  PixelFormat format = PixelFormat::kMono8;
  int width = 0;
  int height = 0;
  ToneCurve tone_curve = ToneCurve::Srgb();
  YuvRange yuv_range = YuvRange::kFull;
};

/// The image in a file of packed bytes. Throws std::runtime_error naming the file and the cause; also where the file
/// has not exactly the bytes that the layout needs. @pre SizeIsValid for the layout.
Image LoadRawImage(const std::filesystem::path& path, const RawLayout& layout);

/// Whether a file's name ends as image files do that LoadImage reads (.png .jpg .jpeg .bmp .pgm .ppm .pnm, any case).
bool HasImageExtension(const std::filesystem::path& path);

}  // namespace chequer
