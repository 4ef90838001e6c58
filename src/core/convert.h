#pragma once

#include "chequer/image.h"

namespace chequer {

/// The image as BGR8. Bayer is demosaiced bilinearly, YUV is taken as BT.601 of the image's range with each chroma
/// sample standing for all pixels that share it. Values keep their tone curve. Not made for speed.
Image ToBgr(const ImageView& image);

/// The image in any format: YUV as BT.601 of the given range, chroma averaged over the pixels that share it; Bayer by
/// leaving out two colours of each pixel; Mono8 as luma. Between YUV formats nothing is converted that need not be, so
/// that repacking YUYV to UYVY loses nothing. @pre SizeIsValid(format, image.width(), image.height()).
Image ConvertImage(const ImageView& image, PixelFormat format, YuvRange yuv_range = YuvRange::kFull);

}  // namespace chequer
