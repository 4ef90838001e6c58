#include "tools/above_zero.h"

#include <charconv>
#include <cmath>

namespace chequer {

std::string IsAboveZero(const std::string& typed) {
  double value = 0;
  const auto [end, error] = std::from_chars(typed.data(), typed.data() + typed.size(), value);
  const bool is_number = error == std::errc() && end == typed.data() + typed.size() && std::isfinite(value);
  return is_number && value > 0 ? "" : "'" + typed + "' must be a number above 0";
}

}  // namespace chequer
