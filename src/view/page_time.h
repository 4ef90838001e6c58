#pragma once

#include <chrono>

namespace chequer {

/// A time as a page has it: milliseconds.
template <typename Time>
double Milliseconds(Time time) {
  return static_cast<double>(std::chrono::time_point_cast<std::chrono::microseconds>(time).time_since_epoch().count()) /
         1000;
}

}  // namespace chequer
