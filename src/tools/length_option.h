#pragma once

#include <string>

namespace chequer {

/// Metres of "60mm", "6cm", "0.06m" or "0.06" (metres). Throws CLI::ValidationError naming the option where it is
/// nothing of this, or not above 0.
double ParseLength(const char* option, const std::string& text);

}  // namespace chequer
