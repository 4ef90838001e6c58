#include "capture/image_pool.h"

#include <cstring>

namespace chequer {

void CopyPixels(const ImageView& from, Image& into) {
  const ImageView old = into.view();
  const bool is_right = old.format() == from.format() && old.width() == from.width() && old.height() == from.height() &&
                        old.tone_curve() == from.tone_curve() && old.yuv_range() == from.yuv_range();
  if (!is_right) into = Image(from.format(), from.width(), from.height(), from.tone_curve(), from.yuv_range());
  const auto shapes = PlaneShapes(from.format(), from.width(), from.height());
  std::uint8_t* to = into.bytes().data();
  for (int plane = 0; plane < 3; ++plane) {
    const PlaneShape& shape = shapes[static_cast<std::size_t>(plane)];
    for (int y = 0; y < shape.rows; ++y, to += shape.row_bytes)
      std::memcpy(to, from.row(y, plane), static_cast<std::size_t>(shape.row_bytes));
  }
}

}  // namespace chequer
