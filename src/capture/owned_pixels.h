#pragma once

#include <memory>
#include <utility>

#include "chequer/frame.h"
#include "chequer/image.h"

namespace chequer {

/// Lets a frame show an image that was made for it alone, and live as long as the frame does.
inline void GiveOwnPixels(Image pixels, Frame& frame) {
  struct Owned final : FrameLease {
    explicit Owned(Image owned) : image(std::move(owned)) {}
    Image image;
  };
  auto owned = std::make_unique<Owned>(std::move(pixels));
  frame.image = owned->image.view();
  frame.lease = std::move(owned);
}

}  // namespace chequer
