#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "chequer/image.h"

namespace chequer {

/// Where the samples of a YUV format lie, whichever way it is packed: sample (column, row) of a channel (0 Y, 1 U, 2 V)
/// is at first + row · row_bytes + column · step. Chroma columns and rows count chroma samples.
struct YuvChannel {
  int plane = 0;
  int first = 0;  ///< byte in the plane
  int step = 1;   ///< bytes
};

struct YuvLayout {
  std::array<YuvChannel, 3> channels;
  int chroma_width = 1;  ///< pixels that share a chroma sample
  int chroma_height = 1;
};

/// @pre IsYuv(format).
YuvLayout LayoutOfYuv(PixelFormat format);

/// Full-range Y, U, V of BT.601 of full-range red, green, blue, and back; U and V about 128. Not clipped.
std::array<float, 3> YuvFromBgr(const std::uint8_t* bgr);
std::array<float, 3> BgrFromYuv(const std::array<float, 3>& yuv);

}  // namespace chequer
