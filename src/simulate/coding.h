#pragma once

#include "chequer/image.h"

namespace chequer {

/// A BGR8 image in another format: RGB8, or any YUV format (BT.601, chroma averaged over the pixels that share it and
/// sited in their middle, as JPEG has it). @pre bgr is BGR8, its size is valid for the format, which is RGB8, BGR8 or
/// YUV.
Image ConvertFromBgr(const ImageView& bgr, PixelFormat format, YuvRange range = YuvRange::kFull);

}  // namespace chequer
