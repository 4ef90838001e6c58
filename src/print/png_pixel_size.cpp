#include "print/png_pixel_size.h"

#include <zlib.h>

#include <array>
#include <cmath>

namespace chequer {
namespace {

void AppendNumber(std::vector<std::uint8_t>& bytes, std::uint32_t number) {
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(number >> shift));
}

}  // namespace

std::vector<std::uint8_t> WithPixelSize(std::span<const std::uint8_t> png, double pixels_per_metre) {
  // The signature and the header: 8 bytes, and a chunk of 13. What is said of pixels comes right after it.
  constexpr std::size_t kHeaderEnd = 8 + 12 + 13;
  const std::uint32_t density = static_cast<std::uint32_t>(std::lround(pixels_per_metre));
  std::vector<std::uint8_t> body{'p', 'H', 'Y', 's'};
  AppendNumber(body, density);
  AppendNumber(body, density);
  body.push_back(1);  // per metre
  std::vector<std::uint8_t> out(png.begin(), png.begin() + kHeaderEnd);
  AppendNumber(out, static_cast<std::uint32_t>(body.size() - 4));
  out.insert(out.end(), body.begin(), body.end());
  AppendNumber(out, static_cast<std::uint32_t>(crc32(0, body.data(), static_cast<uInt>(body.size()))));
  out.insert(out.end(), png.begin() + kHeaderEnd, png.end());
  return out;
}

}  // namespace chequer
