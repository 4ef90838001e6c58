#include "core/crop.h"

#include <algorithm>
#include <array>

#include "core/yuv_samples.h"

namespace chequer {
namespace {

/// Bytes from the first sample of a plane to that of pixel (x, y), both even.
std::ptrdiff_t OffsetIn(const ImageView& image, int plane, int x, int y) {
  const std::ptrdiff_t stride = image.plane(plane).stride_bytes;
  if (!IsYuv(image.format())) {
    const bool colour = image.format() == PixelFormat::kBgr8 || image.format() == PixelFormat::kRgb8;
    return y * stride + (colour ? 3 : 1) * static_cast<std::ptrdiff_t>(x);
  }
  const YuvLayout layout = LayoutOfYuv(image.format());
  for (std::size_t i = 0; i < 3; ++i) {
    const YuvChannel& channel = layout.channels[i];
    if (channel.plane != plane) continue;
    const int column = i == 0 ? x : x / layout.chroma_width, row = i == 0 ? y : y / layout.chroma_height;
    return row * stride + static_cast<std::ptrdiff_t>(column) * channel.step;
  }
  return 0;
}

/// Moves [begin, begin + length) into [0, size), to even ends where there is room.
void Fit(int size, int& begin, int& length) {
  const int first = std::clamp(begin, 0, size) & ~1;
  const int last = std::clamp((std::clamp(begin + length, 0, size) + 1) & ~1, 0, size & ~1);
  begin = first;
  length = std::max(0, last - first);
}

}  // namespace

ImageView Crop(const ImageView& image, int& x, int& y, int& width, int& height) {
  Fit(image.width(), x, width);
  Fit(image.height(), y, height);
  if (width == 0 || height == 0) return {};
  const std::array<PlaneShape, 3> shapes = PlaneShapes(image.format(), width, height);
  std::array<Plane, 3> planes;
  std::size_t count = 0;
  for (; count < 3 && shapes[count].rows > 0; ++count) {
    const Plane& whole = image.plane(static_cast<int>(count));
    planes[count] = {whole.data + OffsetIn(image, static_cast<int>(count), x, y), whole.stride_bytes};
  }
  return {image.format(), width, height, std::span(planes).first(count), image.tone_curve(), image.yuv_range()};
}

}  // namespace chequer
