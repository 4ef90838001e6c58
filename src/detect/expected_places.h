#pragma once

#include "detect/image_state.h"

// Where expected boards lie that are not quite where they are expected: a camera was knocked, or robots steer and
// brake.

namespace chequer {

/// Whether so much of a board's contrast in the last frame shows where it is expected.
bool ShowsShare(const ImageState& frame, std::size_t board, double share);
/// Whether the motion of most boards is known.
bool MostAreFollowed(const ImageState& frame);

/// Moves expected boards to where they show: all by the shift that they share, and each by its own. Says in
/// StreamState what was shared, and how much of their contrast they show. Some may turn out to lie outside the image:
/// they are no longer expected.
void FollowPlaces(const ImageJob& job);

}  // namespace chequer
