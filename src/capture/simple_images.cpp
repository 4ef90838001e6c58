#include "capture/simple_images.h"

#include <array>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

#include "capture/codec_limits.h"

namespace chequer {
namespace {

[[noreturn]] void FailTruncated(std::size_t have, std::size_t need) {
  throw std::runtime_error("it is truncated: " + std::to_string(have) + " bytes of " + std::to_string(need));
}

bool IsSpace(std::uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// The next number of a PNM header, which may have comments before it.
int ReadNumber(std::span<const std::uint8_t>& rest) {
  while (!rest.empty() && (IsSpace(rest[0]) || rest[0] == '#')) {
    const bool comment = rest[0] == '#';
    do rest = rest.subspan(1);
    while (comment && !rest.empty() && rest[0] != '\n');
  }
  int number = 0;
  bool any = false;
  for (; !rest.empty() && rest[0] >= '0' && rest[0] <= '9'; rest = rest.subspan(1)) {
    any = true;
    if (number < 100'000'000) number = 10 * number + (rest[0] - '0');
  }
  if (!any) throw std::runtime_error("its header has no number where one must be");
  return number;
}

std::uint32_t Read32(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] | std::uint32_t{bytes[at + 1]} << 8 | std::uint32_t{bytes[at + 2]} << 16 |
         std::uint32_t{bytes[at + 3]} << 24;
}

std::uint32_t Read16(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] | std::uint32_t{bytes[at + 1]} << 8;
}

struct BmpHeader {
  std::size_t pixels_at = 0;
  int width = 0;
  int height = 0;
  bool top_down = false;
  int bits = 0;
  std::size_t palette_at = 0;
  std::size_t palette_entries = 0;
};

BmpHeader ReadBmpHeader(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kFileHeader = 14, kInfoHeader = 40;
  if (bytes.size() < kFileHeader + kInfoHeader) FailTruncated(bytes.size(), kFileHeader + kInfoHeader);
  const std::size_t info_size = Read32(bytes, kFileHeader);
  if (info_size < kInfoHeader || info_size > 124) throw std::runtime_error("its header is of a kind that is not read");
  BmpHeader header;
  header.pixels_at = Read32(bytes, 10);
  const auto signed_height = static_cast<std::int32_t>(Read32(bytes, 22));
  header.top_down = signed_height < 0;
  const std::int64_t width = static_cast<std::int32_t>(Read32(bytes, 18));
  const std::int64_t height = std::abs(std::int64_t{signed_height});
  CheckPromisedSize(width, height);
  header.width = static_cast<int>(width);
  header.height = static_cast<int>(height);
  header.bits = static_cast<int>(Read16(bytes, 28));
  if (Read32(bytes, 30) != 0) throw std::runtime_error("it is compressed; only uncompressed ones are read");
  if (header.bits != 8 && header.bits != 24 && header.bits != 32)
    throw std::runtime_error("it has " + std::to_string(header.bits) + " bits a pixel; only 8, 24 and 32 are read");
  if (header.bits == 8) {
    header.palette_at = kFileHeader + info_size;
    header.palette_entries = Read32(bytes, 46) == 0 ? 256 : Read32(bytes, 46);
    if (header.palette_entries > 256) throw std::runtime_error("its palette has more than 256 colours");
    const std::size_t end = header.palette_at + 4 * header.palette_entries;
    if (end > bytes.size()) FailTruncated(bytes.size(), end);
  }
  return header;
}

using Palette = std::array<std::array<std::uint8_t, 3>, 256>;

Palette ReadPalette(std::span<const std::uint8_t> bytes, const BmpHeader& header) {
  Palette palette{};
  for (std::size_t i = 0; i < header.palette_entries; ++i)
    for (std::size_t c = 0; c < 3; ++c) palette[i][c] = bytes[header.palette_at + 4 * i + c];
  return palette;
}

bool IsGreyScale(const Palette& palette) {
  for (std::size_t i = 0; i < 256; ++i)
    for (const std::uint8_t value : palette[i])
      if (value != i) return false;
  return true;
}

}  // namespace

Image ImageFromPnm(std::span<const std::uint8_t> bytes, ToneCurve tone_curve) {
  if (bytes.size() < 2 || bytes[0] != 'P' || (bytes[1] != '5' && bytes[1] != '6'))
    throw std::runtime_error("of the PNM files only binary grey (P5) and colour (P6) are read");
  const bool colour = bytes[1] == '6';
  std::span<const std::uint8_t> rest = bytes.subspan(2);
  const int width = ReadNumber(rest);
  const int height = ReadNumber(rest);
  const int largest = ReadNumber(rest);
  CheckPromisedSize(width, height);
  if (largest != 255)
    throw std::runtime_error("its largest value is " + std::to_string(largest) + "; only 255 (8 bits) is read");
  if (rest.empty() || !IsSpace(rest[0])) throw std::runtime_error("its header does not end with a blank");
  rest = rest.subspan(1);
  Image image(colour ? PixelFormat::kBgr8 : PixelFormat::kMono8, width, height, tone_curve);
  const std::span<std::uint8_t> pixels = image.bytes();
  if (rest.size() < pixels.size()) FailTruncated(rest.size(), pixels.size());
  std::memcpy(pixels.data(), rest.data(), pixels.size());
  for (std::size_t i = 0; colour && i < pixels.size(); i += 3) std::swap(pixels[i], pixels[i + 2]);
  return image;
}

Image ImageFromBmp(std::span<const std::uint8_t> bytes, ToneCurve tone_curve) {
  const BmpHeader header = ReadBmpHeader(bytes);
  const auto width = static_cast<std::size_t>(header.width), height = static_cast<std::size_t>(header.height);
  const auto pixel_bytes = static_cast<std::size_t>(header.bits / 8);
  const std::size_t stride = (width * pixel_bytes + 3) / 4 * 4;
  if (header.pixels_at > bytes.size() || bytes.size() - header.pixels_at < stride * height)
    FailTruncated(bytes.size(), header.pixels_at + stride * height);
  const Palette palette = ReadPalette(bytes, header);
  const bool grey = header.bits == 8 && IsGreyScale(palette);
  Image image(grey ? PixelFormat::kMono8 : PixelFormat::kBgr8, header.width, header.height, tone_curve);
  std::uint8_t* to = image.bytes().data();
  for (std::size_t y = 0; y < height; ++y) {
    const std::uint8_t* from = bytes.data() + header.pixels_at + stride * (header.top_down ? y : height - 1 - y);
    for (std::size_t x = 0; x < width; ++x, from += pixel_bytes) {
      const std::uint8_t* pixel = header.bits == 8 ? palette[*from].data() : from;
      for (std::size_t c = 0; c < (grey ? 1u : 3u); ++c) *to++ = pixel[c];
    }
  }
  return image;
}

}  // namespace chequer
