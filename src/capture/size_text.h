#pragma once

#include <string>

namespace chequer {

/// "640x480".
inline std::string SizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace chequer
