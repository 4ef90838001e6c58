#pragma once

#include <array>
#include <string>

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// The curve that turned light into an image's 8-bit values: sRGB (webcams, image files) or value = light^(1/gamma)
/// (industrial cameras: 1 is linear). The photometric fit works in linear light; see tone_curve.cpp for why.
class ToneCurve {
 public:
  static ToneCurve Srgb() { return ToneCurve(0.0); }
  /// @pre 0.2 ≤ gamma ≤ 5.
  static ToneCurve Gamma(double gamma);
  static ToneCurve Linear() { return ToneCurve(1.0); }

  bool is_srgb() const { return gamma_ == 0.0; }
  /// The exponent; 0 for sRGB.
  double gamma() const { return gamma_; }

  /// Light in 0..1 of a value in 0..1.
  double ToLinear(double value) const;
  /// Value in 0..1 of light; light outside 0..1 is cut off there.
  double FromLinear(double light) const;
  /// Light (0..1) of each 8-bit value.
  std::array<float, 256> LinearTable() const;

  /// "sRGB", or "gamma 2.2".
  std::string Name() const;

  bool operator==(const ToneCurve&) const = default;

 private:
  explicit ToneCurve(double gamma) : gamma_(gamma) {}
  double gamma_ = 0.0;
};

}  // namespace chequer

#pragma GCC visibility pop
