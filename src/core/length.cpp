#include "core/length.h"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/number_text.h"

namespace chequer {
namespace {

// "m" last: the others end with it too.
constexpr std::array<std::pair<std::string_view, double>, 5> kUnits{
    {{"um", 1e-6}, {"µm", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}}};

/// Nobody prints a board, or stands a robot, of so many metres; of so many millimetres many do.
constexpr double kLeastOddMetres = 2;

std::optional<double> ParseNumber(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

}  // namespace

std::optional<double> ParseLength(std::string_view text, double bare_m) {
  double unit_m = bare_m;
  for (const auto& [unit, metres] : kUnits)
    if (text.ends_with(unit)) {
      text.remove_suffix(unit.size());
      if (text.ends_with(' ')) text.remove_suffix(1);
      unit_m = metres;
      break;
    }
  const std::optional<double> number = ParseNumber(text);
  if (!number) return std::nullopt;
  // By the reciprocal where that is exact: 60mm is the number that 0.06 is.
  return unit_m < 1 ? *number / std::round(1 / unit_m) : *number * unit_m;
}

std::string LengthText(double metres) {
  return std::abs(metres) < 1 ? RoundText(metres * 1000, 5) + " mm" : RoundText(metres, 5) + " m";
}

std::string DidYouMeanMillimetres(std::string_view text) {
  const std::optional<double> number = ParseNumber(text);
  if (!number || std::abs(*number) < kLeastOddMetres) return {};
  return std::string("; a bare number is in metres: did you mean \"").append(text).append("mm\"?");
}

}  // namespace chequer
