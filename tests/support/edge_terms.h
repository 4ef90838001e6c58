#pragma once

#include <cmath>

#include "detect/fit/photometric_kernel.h"

namespace chequer::test {

/// What the kernel makes of an edge's terms, as its header states it: the light, 0 … 1, so many standard deviations of
/// the blur towards the light side.
inline double LightOf(const EdgeTerms& edge, double deviations) {
  const double size = std::abs(deviations);
  double beyond = 0.5, power = 1;
  for (const float term : edge.by_power) beyond += double{term} * (power *= size);
  beyond *= std::exp(-0.5 * size * size);
  return deviations < 0 ? beyond : 1 - beyond;
}

}  // namespace chequer::test
