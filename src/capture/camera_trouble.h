#pragma once

#include <stdexcept>

namespace chequer {

/// A camera cannot be opened now, and may be later: it is not there, or another program uses it. What can never work is
/// any other std::runtime_error.
class CameraNotReady : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace chequer
