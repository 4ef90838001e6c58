#pragma once

#include <opencv2/core.hpp>

#include "chequer/image.h"

namespace chequer::bench {

/// Converts a BGR8 image to grey, into memory that is used again.
void ConvertToGrey(const Image& colour, cv::Mat& grey);

}  // namespace chequer::bench
