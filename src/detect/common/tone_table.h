#pragma once

#include <array>

#include "chequer/tone_curve.h"

namespace chequer {

/// The table of the tone curve that was asked for last. It is kept from image to image, as a camera hardly ever changes
/// its curve, and depends on nothing but the curve.
class ToneTable {
 public:
  /// Light (0..1) of each 8-bit value. Valid until another curve is asked for.
  const std::array<float, 256>& Of(const ToneCurve& curve) {
    if (!(curve == curve_)) {
      table_ = curve.LinearTable();
      curve_ = curve;
    }
    return table_;
  }

 private:
  ToneCurve curve_ = ToneCurve::Srgb();
  std::array<float, 256> table_ = ToneCurve::Srgb().LinearTable();
};

}  // namespace chequer
