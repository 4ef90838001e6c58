#pragma once

#include <functional>
#include <optional>

#include "chequer/tone_curve.h"

namespace chequer {

/// How badly boards fit with a curve: the less the better, above 0.
using ToneCost = std::function<double(const ToneCurve&)>;

/// A curve with which boards fit better than with the stated one, by half at least; nothing where there is none. It
/// begins with whichever fits best of the stated curve and some gammas, and goes along the gamma; then, where a knee or
/// an S-curve fits better, along the bends. Calls `cost` some 25 times, with bends 160 times at most.
std::optional<ToneCurve> SearchToneCurve(const ToneCurve& stated, const ToneCost& cost);

}  // namespace chequer
