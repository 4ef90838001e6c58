#pragma once

#include <array>

#include "chequer/marker.h"

namespace chequer {

/// What a fit explains of a board's pixels, to compare it with other fits of the board.
struct Explained {
  /// The pixels around one.
  struct Corner {
    float pixels = 0;         ///< that the fit looked at
    float fits = 0;           ///< of them, those that lie within several deviations of the model
    float own_deviation = 0;  ///< of a corner that is not used, over that of the used ones' pixels; 0: it is used
  };
  std::array<Corner, kMaxCorners> corners{};
  double deviation = 1;  ///< from the model, of the pixels of used corners that fit, light
  double unknowns = 0;
  double contrast = 0;  ///< of the board, light
  bool of_few = false;  ///< of large cells, the pixels that the model with all its terms looks at (BoardFit)
};

/// Whether a fit explains a board better than another one. The score of a fit is the log likelihood of a pixel, less
/// what its unknowns explain by chance, over that of a pixel that may be anything within the board's contrast c:
///   score = (Σ_fits ln(c / σ) + Σ_unused ln(c / σ_corner) − k n / (n − k − 1)) / pixels
/// for k unknowns and n pixels that fit (Akaike's criterion for small samples: Hurvich and Tsai, Biometrika 1989). Both
/// are scored as if they had been fitted to as many pixels, the more of the two: to fewer, a model fits more closely by
/// chance and its unknowns are known less well, which says nothing against it. The pixels are the same but for chance,
/// some of the board's or all: those at corners that either fit uses. So a corner that only one gives up costs it what
/// its pixels could tell. One that both give up does not count: nothing has fitted the levels of what occludes it, which
/// would make as much of a difference by chance as the rest of the board.
bool Better(const Explained& fit, const Explained& other, double most_by_chance);
/// Whether it may be, once a rough fit is fitted closely.
bool MayBeBetter(const Explained& rough_fit, const Explained& other, double most_by_chance);

}  // namespace chequer
