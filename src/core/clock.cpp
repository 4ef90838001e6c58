#include "core/clock.h"

namespace chequer {

Clock Clock::System() {
  using std::chrono::microseconds;
  return {[] { return std::chrono::time_point_cast<microseconds>(std::chrono::system_clock::now()); },
          [] { return std::chrono::time_point_cast<microseconds>(std::chrono::steady_clock::now()); }};
}

}  // namespace chequer
