#include "tools/number_check.h"

#include <charconv>
#include <cmath>
#include <optional>

#include "core/number_text.h"

namespace chequer {
namespace {

template <typename Number>
std::optional<Number> Parse(const std::string& typed) {
  Number value{};
  const auto [end, error] = std::from_chars(typed.data(), typed.data() + typed.size(), value);
  if (error != std::errc() || end != typed.data() + typed.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string IsAboveZero(const std::string& typed) {
  const auto value = Parse<double>(typed);
  return value && std::isfinite(*value) && *value > 0 ? "" : "'" + typed + "' must be a number above 0";
}

NumberCheck IsWithin(double min, double max) {
  return [=](const std::string& typed) -> std::string {
    const auto value = Parse<double>(typed);
    if (value && *value >= min && *value <= max) return {};
    return "'" + typed + "' must be a number from " + RoundText(min) + " to " + RoundText(max);
  };
}

NumberCheck IsWhole(std::uint64_t min, std::uint64_t max) {
  return [=](const std::string& typed) -> std::string {
    const auto value = Parse<std::uint64_t>(typed);
    if (value && *value >= min && *value <= max) return {};
    return "'" + typed + "' must be a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  };
}

}  // namespace chequer
