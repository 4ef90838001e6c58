#include "tools/length_option.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <string_view>

namespace chequer {

double ParseLength(const char* option, const std::string& text) {
  std::string_view digits = text;
  double metres = 1;
  // "m" last: the others end with it too.
  for (const auto& [unit, factor] : {std::pair<std::string_view, double>{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}})
    if (digits.ends_with(unit)) {
      digits.remove_suffix(unit.size());
      metres = factor;
      break;
    }
  double number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(number) || !(number > 0))
    throw CLI::ValidationError(option, "'" + text + "' is not a length; write it as 60mm, 6cm, 0.06m or 0.06 (metres)");
  return number * metres;
}

}  // namespace chequer
