#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/image.h"

// Frames for tests of what one frame leaves behind for the next. A test lists mixed_frames.cpp, scenes.cpp and
// stream_frames.cpp among its sources and links chequer_simulate and chequer_detect.

namespace chequer::test {

struct NamedFrame {
  std::string name;  ///< for messages
  Image image;
};

/// Side of the markers in all of these frames, metres.
inline constexpr double kMixedSideM = 0.12;

/// The camera of most of these frames, 640 × 480.
CameraModel MixedCamera();

/// Every condition of the simulator's stress test, twice. Pixel formats and tone curves take turns.
std::vector<NamedFrame> StressFrames();

/// Six boards each: smeared, hidden, in shadow, of ink that has spread, out of focus, dim, steep, and calm ones after
/// every one of them. In several sizes, pixel formats and tone curves; and frames too small for any board, and clutter.
/// @param most of them, the first.
std::vector<NamedFrame> TroubledFrames(std::size_t most = 1000);

/// A few frames of every phase of a stream, one after the other: of the reference stream, and of a smaller one with the
/// other kinds of phases.
std::vector<NamedFrame> StreamSample();

}  // namespace chequer::test
