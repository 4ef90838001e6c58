#pragma once

#include <algorithm>
#include <cmath>

#include "chequer/tone_curve.h"

namespace chequer {

/// The farthest that light by one curve is from that by another, between two values at which both have the same light,
/// as a share of the light between these. Levels of light are free wherever curves matter, so no more of it shows.
/// @pre dark < light.
inline double ToneDistance(const ToneCurve& a, const ToneCurve& b, double dark = 0.15, double light = 0.9) {
  const auto share = [&](const ToneCurve& curve, double value) {
    const double low = curve.ToLinear(dark), high = curve.ToLinear(light);
    return (curve.ToLinear(value) - low) / (high - low);
  };
  double farthest = 0;
  for (int i = 1; i < 32; ++i) {
    const double value = dark + (light - dark) * i / 32;
    farthest = std::max(farthest, std::abs(share(a, value) - share(b, value)));
  }
  return farthest;
}

}  // namespace chequer
