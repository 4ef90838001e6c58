#pragma once

#include <array>
#include <optional>
#include <string>

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// The curve that turned light into an image's 8-bit values: sRGB (webcams, image files) or value = light^(1/gamma)
/// (industrial cameras: 1 is linear). Cameras that bend the shadows or the highlights have bends on top of one of them.
/// The photometric fit works in linear light; see tone_curve.cpp for why.
class ToneCurve {
 public:
  /// What is added to the values 1/8, 2/8, ... 7/8 to have those of the curve without bends. Black and white stay;
  /// between, a monotone cubic leads from one to the next.
  using Bends = std::array<float, 7>;

  static ToneCurve Srgb() { return ToneCurve(0.0); }
  /// @pre 0.2 ≤ gamma ≤ 5.
  static ToneCurve Gamma(double gamma);
  static ToneCurve Linear() { return ToneCurve(1.0); }
  /// The same with bends instead of those it has. Nothing where a larger value would not mean more light: values with
  /// their bends must rise by 0.01 at least from each to the next, from 0 to 1.
  std::optional<ToneCurve> WithBends(const Bends& bends) const;

  /// Without bends, or below them.
  bool is_srgb() const { return gamma_ == 0.0; }
  /// The exponent; 0 for sRGB.
  double gamma() const { return gamma_; }
  bool is_bent() const { return bends_ != Bends{}; }
  const Bends& bends() const { return bends_; }

  /// Light in 0..1 of a value in 0..1.
  double ToLinear(double value) const;
  /// Value in 0..1 of light; light outside 0..1 is cut off there.
  double FromLinear(double light) const;
  /// Light (0..1) of each 8-bit value.
  std::array<float, 256> LinearTable() const;

  /// "sRGB", or "gamma 2.2", or either with ", bent" after it.
  std::string Name() const;

  bool operator==(const ToneCurve&) const = default;

 private:
  explicit ToneCurve(double gamma) : gamma_(gamma) {}
  /// Of a value, the one that the curve without bends has for the same light.
  double Straightened(double value) const;

  double gamma_ = 0.0;
  Bends bends_{};
};

}  // namespace chequer

#pragma GCC visibility pop
