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

/// By how much the score must be better; 0: only the number of unknowns counts against a fit. Measured: what the score
/// gained on boards that have what is tried, and on boards that have something else (40 to 600 of each kind of
/// tests/bench: conditions with shadows, dot gain, blur, motion and occlusion, real_prints with gloss).
double MostByChance(Hypothesis hypothesis) {
  switch (hypothesis) {
    // Where dot gain or a shadow moves all corners, boards gain up to .2 without a side; with a cover on it, .34 and
    // more.
    case Hypothesis::kCoveredSide: return 0.3;
    // Shadows gain up to .04; of 800 boards with a lamp's image nine in ten gain .22 and more, all but one .057.
    case Hypothesis::kHighlight: return 0.05;
    // By chance they lose .07 and more, as they have three times as many unknowns; of dot gain that is not known yet,
    // they explain .02.
    case Hypothesis::kQuadrants: return 0.1;
    // Shadows are tried where quadrants show an edge: they may even lose a little. Under a blur of 3 px true ones lost
    // .06 to rough fits without, whose few pixels do not tell their noise better.
    case Hypothesis::kShadow: return -0.1;
    // True ones gained 1.5 and more.
    case Hypothesis::kDotGain:
    // Boards that moved lose .2 and more where they are fitted as if they stood, and the reverse.
    case Hypothesis::kNoMotion:
    case Hypothesis::kOtherMotion: return 0;
  }
  return 0;
}

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

bool Better(const Explained& fit, const Explained& other, Hypothesis hypothesis) {
  return Gain(fit, other) > MostByChance(hypothesis);
}

bool MayBeBetter(const Explained& rough_fit, const Explained& other, Hypothesis hypothesis) {
  return Gain(rough_fit, other) > MostByChance(hypothesis) - kRoughLacks;
}

}  // namespace chequer
