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

double Score(const Explained& fit, double contrast) {
  const double log_contrast = std::log(std::max(contrast, 1e-6)), n = std::max(fit.fits, 1.0), k = fit.unknowns;
  const double by_chance = k * n / std::max(n - k - 1, kFewestFree * n);
  return (fit.fits * (log_contrast - std::log(fit.deviation)) + fit.unused * log_contrast - fit.unused_logs -
          by_chance) /
         fit.pixels;
}

/// By one contrast: fits without the corners in a shadow else have more.
double Gain(const Explained& fit, const Explained& other) {
  const double contrast = std::max(fit.contrast, other.contrast);
  return Score(fit, contrast) - Score(other, contrast);
}

}  // namespace

bool Better(const Explained& fit, const Explained& other, double most_by_chance) {
  return Gain(fit, other) > most_by_chance;
}

bool MayBeBetter(const Explained& rough_fit, const Explained& other, double most_by_chance) {
  return Gain(rough_fit, other) > most_by_chance - kRoughLacks;
}

}  // namespace chequer
