#include <cstddef>
#include <cstdint>

#include "chequer/check.h"
#include "core/convert.h"
#include "fuzz/frame_input.h"

// Any bytes as a frame of any format and size: it converts to every other format that can have its size.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace chequer;
  const auto frame = fuzz::FrameOf(data, size);
  if (!frame) return 0;
  for (int i = 0; i <= static_cast<int>(PixelFormat::kYuv444p); ++i) {
    const auto format = static_cast<PixelFormat>(i);
    if (!SizeIsValid(format, frame->width(), frame->height())) continue;
    for (const YuvRange range : {YuvRange::kFull, YuvRange::kLimited}) {
      const Image image = ConvertImage(*frame, format, range);
      CHEQUER_CHECK(image.width() == frame->width() && image.height() == frame->height(), "the size changed");
    }
  }
  return 0;
}
