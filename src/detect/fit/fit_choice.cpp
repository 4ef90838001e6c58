#include "detect/fit/fit_choice.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Of the pixels, what unknowns leave to tell their noise, at least.
constexpr double kFewestFree = 0.2;
/// A rough fit lacks so much of its close one's score at most (measured: of shadows and highlights that won, also
/// beside covers, dot gain and blur, those farthest behind as rough fits were so by .49, .40 and .20).
constexpr double kRoughLacks = 0.5;

bool Used(const Explained::Corner& corner) { return corner.own_deviation == 0; }

/// The pixels that a fit explains.
double CountFits(const Explained& fit) {
  double n = 0;
  for (const Explained::Corner& corner : fit.corners)
    if (Used(corner)) n += double{corner.fits};
  return std::max(n, 1.0);
}

/// Of n pixels, those that k unknowns leave.
double Free(double n, double k) { return std::max(n - k, kFewestFree * n); }

/// @param pixels that both fits are compared by: of fewer, unknowns explain more by chance.
double Score(const Explained& fit, const Explained& other, double contrast, double pixels_of_both) {
  const double k = fit.unknowns, n = CountFits(fit),
               as_of_both = n / Free(n, k) * Free(pixels_of_both, k) / pixels_of_both,
               log_contrast = std::log(std::max(contrast, 1e-6) / fit.deviation) - std::log(as_of_both) / 2;
  double logs = 0, pixels = 0;
  for (std::size_t i = 0; i < fit.corners.size(); ++i) {
    const Explained::Corner& corner = fit.corners[i];
    if (!Used(corner) && !Used(other.corners[i])) continue;
    pixels += double{corner.pixels};
    if (!Used(corner))
      logs += double{corner.pixels} * std::max(log_contrast - std::log(double{corner.own_deviation}), 0.0);
  }
  return (n * (log_contrast - k / Free(pixels_of_both, k + 1)) + logs) / std::max(pixels, 1.0);
}

/// By one contrast: fits without the corners in a shadow else have more.
double Gain(const Explained& fit, const Explained& other) {
  const double contrast = std::max(fit.contrast, other.contrast), pixels = std::max(CountFits(fit), CountFits(other));
  return Score(fit, other, contrast, pixels) - Score(other, fit, contrast, pixels);
}

}  // namespace

bool Better(const Explained& fit, const Explained& other, double most_by_chance) {
  return Gain(fit, other) > most_by_chance;
}

bool MayBeBetter(const Explained& rough_fit, const Explained& other, double most_by_chance) {
  return Gain(rough_fit, other) > most_by_chance - kRoughLacks;
}

}  // namespace chequer
