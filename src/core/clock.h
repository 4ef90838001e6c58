#pragma once

#include <functional>

#include "chequer/frame.h"

namespace chequer {

/// Where a part of the program reads the time; tests hand in a clock that they drive.
struct Clock {
  std::function<UtcTime()> utc;
  std::function<MonotonicTime()> monotonic;

  /// The host's clocks.
  static Clock System();
};

}  // namespace chequer
