#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

#include "capture/image_file.h"
#include "chequer/check.h"

// Any bytes: a whole image or a std::runtime_error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  for (const auto colour : {chequer::JpegColour::kBgr, chequer::JpegColour::kYuv}) {
    try {
      const chequer::Image image =
          chequer::DecodeImage({data, size}, {.one_channel = chequer::PixelFormat::kBayerRg8, .jpeg_colour = colour});
      CHEQUER_CHECK(!image.empty(), "an empty image is no image");
    } catch (const std::runtime_error&) {
      // What a bad file must give.
    }
  }
  return 0;
}
