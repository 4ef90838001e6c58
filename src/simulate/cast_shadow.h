#pragma once

#include <cmath>
#include <numbers>
#include <string>

namespace chequer {

/// A shadow on the scene, of something beside the camera that is in a lamp's way.
struct CastShadow {
  double takes = 0;                     ///< of the light, far beyond its edge, 0..1
  double direction_rad = 0;             ///< from the edge into the shadow: 0 right, π/2 down
  double through_x = 0, through_y = 0;  ///< a point of the edge, pixels
  double width_px = 1;                  ///< standard deviation of the edge, as a round lamp blurs it, above 0

  /// What it leaves of the light at a pixel.
  double LightAt(double x, double y) const {
    const double beyond = (x - through_x) * std::cos(direction_rad) + (y - through_y) * std::sin(direction_rad);
    return 1 - takes * 0.5 * std::erfc(-beyond / (std::numbers::sqrt2 * width_px));
  }
  /// Empty, or what is wrong and what would be right.
  std::string Check() const {
    if (!(takes >= 0 && takes <= 1)) return "shadow.takes must be from 0 to 1";
    if (!(width_px > 0)) return "shadow.width_px must be above 0";
    return {};
  }
};

}  // namespace chequer
