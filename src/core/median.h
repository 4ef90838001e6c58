#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace chequer {

/// The middle one of the values, the upper of two middle ones; 0 where there are none.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace chequer
