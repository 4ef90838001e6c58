#pragma once

#include <string>

namespace chequer {

/// A check of an option's value: empty where it is a number above zero, else what is wrong. CLI11's own names the
/// largest number with all its 309 digits.
std::string IsAboveZero(const std::string& typed);

}  // namespace chequer
