#include "chequer/tone_curve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "chequer/check.h"

// A lens blurs light, not coded values: an edge that is symmetric in light is lopsided after the camera's curve, and a
// fit on coded values is 5 to 10 times worse in tilt. Hence every stage that measures works on linear light.

namespace chequer {
namespace {

constexpr int kIntervals = 8;
constexpr double kLeastRise = 0.01;

/// Values with their bends, black and white included.
std::array<double, kIntervals + 1> Knots(const ToneCurve::Bends& bends) {
  std::array<double, kIntervals + 1> knots{};
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const bool is_end = i == 0 || i + 1 == knots.size();
    knots[i] = static_cast<double>(i) / kIntervals + (is_end ? 0.0 : static_cast<double>(bends[i - 1]));
  }
  return knots;
}

/// Slope at a knot between intervals of those slopes (Fritsch and Butland, 1984): the cubics then are monotone.
double SlopeAt(double before, double after) { return before * after <= 0 ? 0 : 2 * before * after / (before + after); }

}  // namespace

ToneCurve ToneCurve::Gamma(double gamma) {
  CHEQUER_CHECK(gamma >= 0.2 && gamma <= 5.0, "gamma must be from 0.2 to 5");
  return ToneCurve(gamma);
}

std::optional<ToneCurve> ToneCurve::WithBends(const Bends& bends) const {
  const auto knots = Knots(bends);
  for (std::size_t i = 0; i + 1 < knots.size(); ++i)
    if (!(knots[i + 1] - knots[i] >= kLeastRise)) return std::nullopt;
  ToneCurve bent = *this;
  bent.bends_ = bends;
  return bent;
}

double ToneCurve::Straightened(double value) const {
  const auto knots = Knots(bends_);
  const double at = std::clamp(value, 0.0, 1.0) * kIntervals;
  const int i = std::min(static_cast<int>(at), kIntervals - 1);
  const auto rise = [&](int k) {
    const auto from = static_cast<std::size_t>(std::clamp(k, 0, kIntervals - 1));
    return knots[from + 1] - knots[from];
  };
  // Cubic of Hermite; beyond black and white the curve goes straight on.
  const double t = at - i, low = knots[static_cast<std::size_t>(i)], here = rise(i);
  const double m0 = SlopeAt(rise(i - 1), here), m1 = SlopeAt(here, rise(i + 1));
  return low + t * (m0 + t * (3 * here - 2 * m0 - m1 + t * (m0 + m1 - 2 * here)));
}

double ToneCurve::ToLinear(double value) const {
  if (is_bent()) value = Straightened(value);
  if (!is_srgb()) return std::pow(std::max(value, 0.0), gamma_);
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);  // IEC 61966-2-1
}

double ToneCurve::FromLinear(double light) const {
  light = std::clamp(light, 0.0, 1.0);
  const double straight = !is_srgb()           ? std::pow(light, 1.0 / gamma_)
                          : light <= 0.0031308 ? 12.92 * light
                                               : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
  if (!is_bent()) return straight;
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (Straightened(middle) < straight ? low : high) = middle;
  }
  return (low + high) / 2;
}

std::array<float, 256> ToneCurve::LinearTable() const {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<float>(ToLinear(static_cast<double>(i) / 255.0));
  return table;
}

std::string ToneCurve::Name() const {
  const char* bent = is_bent() ? ", bent" : "";
  char text[48];
  if (is_srgb())
    std::snprintf(text, sizeof text, "sRGB%s", bent);
  else
    std::snprintf(text, sizeof text, "gamma %g%s", gamma_, bent);
  return text;
}

}  // namespace chequer
