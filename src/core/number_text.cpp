#include "core/number_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace chequer {

std::string ExactText(double number) {
  if (number == 0 && std::signbit(number)) return "-0.0";  // -0 is a whole number in TOML, which has no such zero
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {text.data(), end};
}

std::string RoundText(double number, int digits) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, number);
  return text.data();
}

}  // namespace chequer
