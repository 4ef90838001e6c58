#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace chequer {

/// The middle one of the values, the upper of two middle ones. Reorders them. @pre there are some.
template <typename T>
T MedianInPlace(std::vector<T>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The same of values that are to stay as they are; 0 where there are none.
inline double Median(std::vector<double> values) { return values.empty() ? 0 : MedianInPlace(values); }

}  // namespace chequer
