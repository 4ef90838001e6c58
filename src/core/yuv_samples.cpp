#include "core/yuv_samples.h"

#include "chequer/check.h"

namespace chequer {

YuvLayout LayoutOfYuv(PixelFormat format) {
  switch (format) {
    case PixelFormat::kYuyv: return {{{{0, 0, 2}, {0, 1, 4}, {0, 3, 4}}}, 2, 1};
    case PixelFormat::kUyvy: return {{{{0, 1, 2}, {0, 0, 4}, {0, 2, 4}}}, 2, 1};
    case PixelFormat::kNv12: return {{{{0, 0, 1}, {1, 0, 2}, {1, 1, 2}}}, 2, 2};
    case PixelFormat::kYuv420p: return {{{{0, 0, 1}, {1, 0, 1}, {2, 0, 1}}}, 2, 2};
    case PixelFormat::kYuv422p: return {{{{0, 0, 1}, {1, 0, 1}, {2, 0, 1}}}, 2, 1};
    case PixelFormat::kYuv444p: return {{{{0, 0, 1}, {1, 0, 1}, {2, 0, 1}}}, 1, 1};
    default: FailCheck("IsYuv(format)", __FILE__, __LINE__, "not a YUV format");
  }
}

// ITU-R BT.601, as JFIF writes it out.
std::array<float, 3> YuvFromBgr(const std::uint8_t* bgr) {
  const float b = bgr[0], g = bgr[1], r = bgr[2];
  const float y = 0.299f * r + 0.587f * g + 0.114f * b;
  return {y, 128 + (b - y) / 1.772f, 128 + (r - y) / 1.402f};
}

std::array<float, 3> BgrFromYuv(const std::array<float, 3>& yuv) {
  const float b = yuv[0] + 1.772f * (yuv[1] - 128);
  const float r = yuv[0] + 1.402f * (yuv[2] - 128);
  return {b, (yuv[0] - 0.299f * r - 0.114f * b) / 0.587f, r};
}

}  // namespace chequer
