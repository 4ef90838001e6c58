#pragma once

namespace chequer {

/// What a fit explains of a board's pixels, to compare it with other fits of the board.
struct Explained {
  double pixels = 1;     ///< that the fit looked at, also those that it gives up
  double fits = 0;       ///< of them, those at used corners that lie within several deviations of the model
  double deviation = 1;  ///< of these pixels from the model, light
  double unknowns = 0;
  double contrast = 0;  ///< of the board, light
  /// At corners that are not used: pixels, and the sum of the logarithms of their corners' deviations.
  double unused = 0, unused_logs = 0;
};

/// Whether a fit explains a board better than another one. The score of a fit is the log likelihood of a pixel, less
/// what its unknowns explain by chance, over that of a pixel that may be anything within the board's contrast c:
///   score = (Σ_fits ln(c / σ) + Σ_unused ln(c / σ_corner) − k n / (n − k − 1)) / pixels
/// for k unknowns and n pixels that fit (Akaike's criterion for small samples: Hurvich and Tsai, Biometrika 1989). The
/// pixels are the same but for chance: some of the board's, or all. So a corner that is given up costs what its pixels
/// could tell.
bool Better(const Explained& fit, const Explained& other, double most_by_chance);
/// Whether it may be, once a rough fit is fitted closely.
bool MayBeBetter(const Explained& rough_fit, const Explained& other, double most_by_chance);

}  // namespace chequer
