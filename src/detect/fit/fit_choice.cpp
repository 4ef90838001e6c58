#include "detect/fit/fit_choice.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Of the pixels, what unknowns leave to tell their noise, at least.
constexpr double kFewestFree = 0.2;
/// A rough fit lacks so much of its close one's score at most. Measured: shadows and highlights that won, also those of
/// boards with dot gain that came to be known later, were behind by up to .42 as rough fits.
constexpr double kRoughLacks = 0.6;

double Score(const Explained& fit, const Explained& other, double contrast) {
  const double log_contrast = std::log(std::max(contrast, 1e-6)) - std::log(fit.deviation), k = fit.unknowns;
  double n = 0, pixels = 0, logs = 0;
  for (std::size_t i = 0; i < fit.corners.size(); ++i) {
    const Explained::Corner& corner = fit.corners[i];
    const bool used = corner.own_deviation == 0;
    if (!used && other.corners[i].own_deviation > 0) continue;
    pixels += double{corner.pixels};
    if (used)
      n += double{corner.fits};
    else
      logs += double{corner.pixels} * std::max(log_contrast - std::log(double{corner.own_deviation}), 0.0);
  }
  n = std::max(n, 1.0);
  const double by_chance = k * n / std::max(n - k - 1, kFewestFree * n);
  return (n * log_contrast + logs - by_chance) / std::max(pixels, 1.0);
}

/// By one contrast: fits without the corners in a shadow else have more.
double Gain(const Explained& fit, const Explained& other) {
  const double contrast = std::max(fit.contrast, other.contrast);
  return Score(fit, other, contrast) - Score(other, fit, contrast);
}

}  // namespace

bool Better(const Explained& fit, const Explained& other, double most_by_chance) {
  return Gain(fit, other) > most_by_chance;
}

bool MayBeBetter(const Explained& rough_fit, const Explained& other, double most_by_chance) {
  return Gain(rough_fit, other) > most_by_chance - kRoughLacks;
}

}  // namespace chequer
