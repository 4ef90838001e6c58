#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/detector.h"
#include "chequer/image.h"

// Frames that ask for as much work as a detector can be made to do. A test lists adversarial_frames.cpp and
// adversarial_textures.cpp among its sources and links chequer_simulate.

namespace chequer::test {

/// A frame and what is sought in it.
struct HardFrame {
  Image image;
  DetectorOptions options;    ///< family and camera
  std::size_t boards = 0;     ///< that are in it
};

/// A swarm of sharp boards with cells of 10 px, 16 of them on 1280 × 720 and 50 on 1920 × 1080: what other frames are
/// compared with.
inline constexpr std::string_view kCalm = "calm";

/// Names of all frames: swarms in trouble ("knocked16" … "knocked100": moved by 14 px; "moved50": by 8 px; "soft50":
/// blurred by 1.7 px; "bled50": a dot gain of a tenth of a cell; "bled8", "bled12": the same of large boards;
/// "nameless50": no code that is one; "mirrored50"; "thousand": 1,000 small boards), and textures
/// (adversarial_textures.h).
std::vector<std::string> HardFrameNames();

/// What is sought in all frames of a size: one family, by one camera.
DetectorOptions HardFrameOptions(int width, int height);

/// The same arguments give the same bytes. @param seed of places, ids and noise. Throws std::runtime_error where there
/// is none of that name.
HardFrame DrawHardFrame(std::string_view name, int width, int height, std::uint64_t seed = 1);

}  // namespace chequer::test
