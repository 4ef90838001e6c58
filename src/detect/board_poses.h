#pragma once

#include "detect/image_state.h"

namespace chequer {

/// Writes down the poses of all boards that are accepted, once all are fitted: how far edges are off that follow the
/// pixels, the whole image tells better than one board.
void DescribePoses(ImageState& frame);

}  // namespace chequer
