#pragma once

#include "chequer/image.h"

namespace chequer {

/// A part of an image, which it borrows. The rectangle is moved into the image and to even pixels, as colour formats
/// need it: at most one pixel more on each side. @param x, y, width, height out: where it lies. Empty where nothing is
/// left.
ImageView Crop(const ImageView& image, int& x, int& y, int& width, int& height);

}  // namespace chequer
