#pragma once

#include <string>

namespace chequer {

/// The shortest text that reads back as the same number, also from TOML.
std::string ExactText(double number);

/// The number rounded to so many significant digits, for people.
std::string RoundText(double number, int digits = 6);

}  // namespace chequer
