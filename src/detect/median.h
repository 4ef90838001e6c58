#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace chequer {

/// The value in the middle, of an even number the upper one. Reorders the values.
/// @pre there are some.
inline float Median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace chequer
