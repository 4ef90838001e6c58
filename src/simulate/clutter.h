#pragma once

#include <opencv2/core.hpp>

#include "simulate/background.h"
#include "simulate/random.h"

namespace chequer {

/// Draws a procedural kind over the whole image: 8-bit sRGB-coded BGR. @pre the kind is neither kPlain nor kImage.
void DrawClutter(BackgroundKind kind, cv::Mat& image, Random& random);

}  // namespace chequer
