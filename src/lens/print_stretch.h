#pragma once

#include <span>
#include <vector>

#include "lens/bundle.h"

namespace chequer {

/// How much taller a target is against its width than it was meant to be: printers stretch what they feed otherwise
/// than what they write along. Views that turn the target against the image tell it from a lens with fx other than fy.
struct PrintStretch {
  double stretch = 0;    ///< printed height over nominal, over the same of the width, less 1
  double deviation = 0;  ///< standard deviation

  /// Whether it is beyond noise, and beyond what matters: a tenth of a percent.
  bool matters() const;
};

/// By least squares from a bundle that explains the views with `fit`: three bundles, of targets a little lower, as
/// meant, and a little taller, and the parabola through what they leave unexplained. A deviation of 1 where the views
/// do not tell. Nothing of the absolute size shows in any view; only a ruler tells that.
PrintStretch FindPrintStretch(std::span<const LensView> views, const Bundle& bundle, const BundleFit& fit);

/// The views of a target that is as much taller.
std::vector<LensView> Stretched(std::span<const LensView> views, double stretch);

}  // namespace chequer
