#pragma once

#include <algorithm>
#include <chrono>
#include <string>

#include "chequer/frame.h"

namespace chequer::test {

/// A time of a test that begins at 0.
inline MonotonicTime At(int ms) { return MonotonicTime(std::chrono::milliseconds(ms)); }

inline int Lines(const std::string& text) { return static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

}  // namespace chequer::test
