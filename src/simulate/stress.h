#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "chequer/marker.h"
#include "simulate/render.h"

namespace chequer {

/// A frame in which one thing is made hard.
struct StressCase {
  std::string tag;  ///< which, and how much: "tilt_deg=60"
  RenderOptions options;
  Scene scene;  ///< one marker
};

/// A marker of 0.12 m seen by a camera of f = 1000 px, 640 × 480: side from 18 px to the whole frame, tilt, blur, shot
/// noise, motion, exposure, gradient, haze, white balance, JPEG, hidden strips. The seed chooses ids, places and
/// headings.
std::vector<StressCase> StressCases(const MarkerCode& code, std::uint64_t seed);

}  // namespace chequer
