#include "capture/image_file.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "capture/png.h"
#include "capture/simple_images.h"
#include "chequer/check.h"
#include "core/file.h"

namespace chequer {
namespace {

bool StartsWith(std::span<const std::uint8_t> bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

std::span<const std::uint8_t> AsBytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The same bytes under another name of format.
Image Relabelled(const Image& image, PixelFormat format) {
  Image other(format, image.width(), image.height(), image.view().tone_curve());
  std::copy(image.bytes().begin(), image.bytes().end(), other.bytes().begin());
  return other;
}

/// The image, and in front of what goes wrong the kind of file.
template <typename Decode>
Image Named(const char* kind, const Decode& decode) {
  try {
    return decode();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("unusable ") + kind + " file: " + error.what());
  }
}

Image DecodeKnownKind(std::span<const std::uint8_t> bytes, const ImageFileOptions& options) {
  if (bytes.empty()) throw std::runtime_error("the file is empty");
  if (StartsWith(bytes, "\x89PNG\r\n\x1a\n"))
    return Named("PNG", [&] { return ImageFromPng(bytes, options.tone_curve); });
  if (StartsWith(bytes, "\xff\xd8"))
    return Named("JPEG", [&] { return ImageFromJpeg(bytes, options.jpeg_colour, options.tone_curve); });
  if (StartsWith(bytes, "BM")) return Named("BMP", [&] { return ImageFromBmp(bytes, options.tone_curve); });
  if (bytes.size() > 1 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '7')
    return Named("PNM", [&] { return ImageFromPnm(bytes, options.tone_curve); });
  throw std::runtime_error("not an image of a kind that is read here (PNG, JPEG, BMP, PGM, PPM)");
}

}  // namespace

Image DecodeImage(std::span<const std::uint8_t> bytes, const ImageFileOptions& options) {
  CHEQUER_CHECK(options.one_channel == PixelFormat::kMono8 || IsBayer(options.one_channel),
                "one channel holds Mono8 or Bayer");
  Image image = DecodeKnownKind(bytes, options);
  if (image.format() == PixelFormat::kMono8 && options.one_channel != PixelFormat::kMono8)
    return Relabelled(image, options.one_channel);
  return image;
}

Image LoadImage(const std::filesystem::path& path, const ImageFileOptions& options) {
  const std::string bytes = ReadFile(path, kMaxImageFileBytes);
  try {
    return DecodeImage(AsBytes(bytes), options);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path.string() + ": " + error.what());
  }
}

Image LoadRawImage(const std::filesystem::path& path, const RawLayout& layout) {
  Image image(layout.format, layout.width, layout.height, layout.tone_curve, layout.yuv_range);
  const std::span<std::uint8_t> pixels = image.bytes();
  const std::string bytes = ReadFile(path, kMaxImageFileBytes);
  if (bytes.size() != pixels.size())
    throw std::runtime_error(path.string() + ": has " + std::to_string(bytes.size()) + " bytes; " +
                             std::to_string(layout.width) + " x " + std::to_string(layout.height) + " " +
                             std::string(PixelFormatName(layout.format)) + " needs " + std::to_string(pixels.size()));
  std::memcpy(pixels.data(), bytes.data(), pixels.size());
  return image;
}

bool HasImageExtension(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 7> kExtensions{".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".pnm"};
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

}  // namespace chequer
