#include "simulate/coding.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "chequer/check.h"

namespace chequer {
namespace {

/// Full-range Y, Cb, Cr of BT.601, each 0..255 with Cb and Cr about 128.
std::array<float, 3> ToYuv(const std::uint8_t* bgr) {
  const float b = bgr[0], g = bgr[1], r = bgr[2];
  const float y = 0.299f * r + 0.587f * g + 0.114f * b;
  return {y, 128 + (b - y) / 1.772f, 128 + (r - y) / 1.402f};
}

std::uint8_t CodeSample(float value, bool luma, YuvRange range) {
  if (range == YuvRange::kLimited) value = luma ? 16 + value * 219 / 255 : 128 + (value - 128) * 224 / 255;
  return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f));
}

/// Where the samples of a format go: strides and steps in bytes.
struct YuvLayout {
  std::uint8_t* data[3];
  std::size_t stride[3];
  std::size_t step[3];
  int chroma_width;  ///< pixels that share a chroma sample
  int chroma_height;
};

YuvLayout LayoutOf(Image& image) {
  const auto shapes = PlaneShapes(image.format(), image.width(), image.height());
  std::array<std::uint8_t*, 3> plane{};
  std::array<std::size_t, 3> row{};
  std::uint8_t* next = image.bytes().data();
  for (std::size_t i = 0; i < 3; ++i) {
    plane[i] = next;
    row[i] = static_cast<std::size_t>(shapes[i].row_bytes);
    next += row[i] * static_cast<std::size_t>(shapes[i].rows);
  }
  switch (image.format()) {
    case PixelFormat::kYuyv: return {{plane[0], plane[0] + 1, plane[0] + 3}, {row[0], row[0], row[0]}, {2, 4, 4}, 2, 1};
    case PixelFormat::kUyvy: return {{plane[0] + 1, plane[0], plane[0] + 2}, {row[0], row[0], row[0]}, {2, 4, 4}, 2, 1};
    case PixelFormat::kNv12: return {{plane[0], plane[1], plane[1] + 1}, {row[0], row[1], row[1]}, {1, 2, 2}, 2, 2};
    case PixelFormat::kYuv420p: return {{plane[0], plane[1], plane[2]}, {row[0], row[1], row[2]}, {1, 1, 1}, 2, 2};
    case PixelFormat::kYuv422p: return {{plane[0], plane[1], plane[2]}, {row[0], row[1], row[2]}, {1, 1, 1}, 2, 1};
    case PixelFormat::kYuv444p: return {{plane[0], plane[1], plane[2]}, {row[0], row[1], row[2]}, {1, 1, 1}, 1, 1};
    default: FailCheck("IsYuv(format)", __FILE__, __LINE__, "not a YUV format");
  }
}

/// One chroma sample's pixels: their luma each, and the mean of their chroma.
void ConvertBlock(const ImageView& bgr, int x0, int y0, YuvRange range, const YuvLayout& out) {
  float u = 0, v = 0;
  int pixels = 0;
  for (int y = y0; y < std::min(y0 + out.chroma_height, bgr.height()); ++y)
    for (int x = x0; x < std::min(x0 + out.chroma_width, bgr.width()); ++x) {
      const auto yuv = ToYuv(bgr.row(y) + 3 * x);
      out.data[0][static_cast<std::size_t>(y) * out.stride[0] + static_cast<std::size_t>(x) * out.step[0]] =
          CodeSample(yuv[0], true, range);
      u += yuv[1];
      v += yuv[2];
      ++pixels;
    }
  const auto row = static_cast<std::size_t>(y0 / out.chroma_height);
  const auto column = static_cast<std::size_t>(x0 / out.chroma_width);
  const auto count = static_cast<float>(pixels);
  out.data[1][row * out.stride[1] + column * out.step[1]] = CodeSample(u / count, false, range);
  out.data[2][row * out.stride[2] + column * out.step[2]] = CodeSample(v / count, false, range);
}

}  // namespace

Image ConvertFromBgr(const ImageView& bgr, PixelFormat format, YuvRange range) {
  CHEQUER_CHECK(bgr.format() == PixelFormat::kBgr8, "only BGR8 is converted");
  Image out(format, bgr.width(), bgr.height(), bgr.tone_curve(), range);
  if (format == PixelFormat::kBgr8 || format == PixelFormat::kRgb8) {
    const int first = format == PixelFormat::kBgr8 ? 0 : 2;
    std::uint8_t* to = out.bytes().data();
    for (int y = 0; y < bgr.height(); ++y)
      for (int x = 0; x < bgr.width(); ++x)
        for (int c = 0; c < 3; ++c) *to++ = bgr.row(y)[3 * x + std::abs(first - c)];
    return out;
  }
  const YuvLayout layout = LayoutOf(out);
  for (int y = 0; y < bgr.height(); y += layout.chroma_height)
    for (int x = 0; x < bgr.width(); x += layout.chroma_width) ConvertBlock(bgr, x, y, range, layout);
  return out;
}

}  // namespace chequer
