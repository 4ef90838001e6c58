// The light of cells' middles, a few thousand of them a frame: LightReader's short way.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "detect/common/light.h"

namespace chequer {
namespace {

/// Light at a value between two codes.
float Between(const std::array<float, 256>& table, float code) {
  const std::size_t below = static_cast<std::size_t>(code), above = std::min<std::size_t>(below + 1, 255);
  return table[below] + (code - static_cast<float>(below)) * (table[above] - table[below]);
}

/// Bytes of a short row of pixels with three colours, which are summed side by side, with those that follow.
constexpr int kShortRow = 16;
using ByteSums = std::array<std::uint16_t, kShortRow>;

/// Down the columns of bytes of so many rows, at most kShortRow.
ByteSums SumRows(const std::uint8_t* row, std::ptrdiff_t stride, int rows) {
  ByteSums sums{};
  for (; rows > 0; --rows, row += stride)
    for (std::size_t k = 0; k < kShortRow; ++k) sums[k] = static_cast<std::uint16_t>(sums[k] + row[k]);
  return sums;
}

/// First of `size` pixels around `at`, of `all`.
int FirstAround(float at, int size, int all) {
  const int first = static_cast<int>(at - 0.5f * static_cast<float>(size - 1) + 0.5f);
  return std::clamp(first, 0, all - size);
}

}  // namespace

Eigen::Vector3f LightReader::RoughRgb(float x, float y, float half_px) const {
  const bool bayer = IsBayer(image_.format());
  const int least = bayer ? 2 : 1, most = std::min(width(), height());
  const int size = std::min(std::max(static_cast<int>(2 * half_px), least), most);
  const int x0 = FirstAround(std::clamp(x, 0.0f, static_cast<float>(width() - 1)), size, width()),
            y0 = FirstAround(std::clamp(y, 0.0f, static_cast<float>(height() - 1)), size, height());
  if (size == least) return bayer ? RgbOfTile(x0, y0) : RgbAt(x0, y0);
  const Codes codes = bayer ? MeanOfMosaic(x0, y0, size) : MeanOfPixels(x0, y0, size);
  switch (image_.format()) {
    case PixelFormat::kYuyv:
    case PixelFormat::kUyvy:
    case PixelFormat::kNv12:
    case PixelFormat::kYuv420p:
    case PixelFormat::kYuv422p:
    case PixelFormat::kYuv444p: return LightOfYuv(codes);
    default: return {Between(table_, codes[0]), Between(table_, codes[1]), Between(table_, codes[2])};
  }
}

Eigen::Vector3f LightReader::RgbOfTile(int x0, int y0) const {
  const std::uint8_t* const rows[2] = {image_.row(y0) + x0, image_.row(y0 + 1) + x0};
  const int row = (y0 ^ mosaic_->red_y) & 1, col = (x0 ^ mosaic_->red_x) & 1;  // of red; blue lies opposite
  const auto light = [&](int of_row, int of_col) { return table_[rows[of_row][of_col]]; };
  return {light(row, col), (light(row, 1 - col) + light(1 - row, col)) / 2, light(1 - row, 1 - col)};
}

LightReader::Codes LightReader::MeanOfPixels(int x0, int y0, int size) const {
  std::array<int, 3> sum{};
  const bool interleaved = image_.format() == PixelFormat::kBgr8 || image_.format() == PixelFormat::kRgb8;
  if (interleaved && 3 * size <= kShortRow && 3 * (width() - x0) >= kShortRow) {
    const ByteSums bytes = SumRows(image_.row(y0) + 3 * x0, image_.row(1) - image_.row(0), size);
    for (std::size_t at = 0, end = static_cast<std::size_t>(3 * size); at < end; at += 3)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += bytes[at + c];
    if (image_.format() == PixelFormat::kBgr8) std::swap(sum[0], sum[2]);
    return Eigen::Array3i(sum[0], sum[1], sum[2]).cast<float>() / static_cast<float>(size * size);
  }
  const auto each_row = [&](const auto& add) {
    for (int y = y0; y < y0 + size; ++y) add(image_.row(y) + step_ * x0, y);
  };
  switch (image_.format()) {
    case PixelFormat::kBgr8:
    case PixelFormat::kRgb8:
      each_row([&](const std::uint8_t* p, int) {
        for (int k = 0; k < size; ++k, p += 3)
          for (std::size_t c = 0; c < 3; ++c) sum[c] += p[c];
      });
      if (image_.format() == PixelFormat::kBgr8) std::swap(sum[0], sum[2]);
      break;
    case PixelFormat::kMono8:
      each_row([&](const std::uint8_t* p, int) {
        for (int k = 0; k < size; ++k) sum[0] += p[k];
      });
      sum[1] = sum[2] = sum[0];
      break;
    default:
      each_row([&](const std::uint8_t*, int y) {
        for (int x = x0; x < x0 + size; ++x) {
          const std::array<int, 3> yuv = YuvAt(x, y);
          for (std::size_t c = 0; c < 3; ++c) sum[c] += yuv[c];
        }
      });
  }
  return Eigen::Array3i(sum[0], sum[1], sum[2]).cast<float>() / static_cast<float>(size * size);
}

LightReader::Codes LightReader::MeanOfMosaic(int x0, int y0, int size) const {
  // By row and column of the square, odd or even.
  std::array<std::array<int, 2>, 2> sums{};
  for (int row = 0; row < size; ++row) {
    const std::uint8_t* p = image_.row(y0 + row) + x0;
    int even = 0, odd = 0;
    for (int col = 0; col + 1 < size; col += 2) even += p[col], odd += p[col + 1];
    if (size % 2) even += p[size - 1];
    std::array<int, 2>& sum = sums[static_cast<std::size_t>(row % 2)];
    sum[0] += even;
    sum[1] += odd;
  }
  // Red and blue lie in opposite places of the tile, the greens in the other two.
  const std::size_t red_row = static_cast<std::size_t>((y0 ^ mosaic_->red_y) & 1),
                    red_col = static_cast<std::size_t>((x0 ^ mosaic_->red_x) & 1);
  const std::array<int, 2> in_line{(size + 1) / 2, size / 2};
  const auto pixels = [&](std::size_t row, std::size_t col) { return in_line[row] * in_line[col]; };
  const std::size_t row = 1 - red_row, col = 1 - red_col;
  const Eigen::Array3i sum(sums[red_row][red_col], sums[red_row][col] + sums[row][red_col], sums[row][col]);
  const Eigen::Array3i count(pixels(red_row, red_col), pixels(red_row, col) + pixels(row, red_col), pixels(row, col));
  return sum.cast<float>() / count.cast<float>();
}

}  // namespace chequer
