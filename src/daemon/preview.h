#pragma once

#include <vector>

#include "chequer/image.h"
#include "publish/view_messages.h"

namespace chequer {

/// A small picture of a frame, for people: a JPEG.
struct Preview {
  PixelRegion region;  ///< of the frame, which it shows
  int width = 0, height = 0;
  std::vector<std::uint8_t> jpeg;
};

/// Makes previews. Each pixel is the mean of two of the frame, which takes a tenth of the time of all of them and shows
/// markers as well. Raw linear values are shown as a screen needs them. Holds scratch memory; one a thread.
class PreviewMaker {
 public:
  /// @param region of the frame; whole, or beyond the frame, as ask_t says. @param width of the picture, pixels; it is
  /// no wider than the region. Without a picture where nothing of the region lies in the frame.
  Preview Make(const ImageView& image, const PixelRegion& region, int width);

 private:
  Image scaled_;
};

}  // namespace chequer
