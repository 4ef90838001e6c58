#pragma once

#include <array>
#include <optional>

namespace chequer {

struct ParabolaPoint {
  double at = 0, value = 0;
};

/// Where a parabola is lowest, and its second derivative, above 0.
struct Parabola {
  double at = 0, bend = 0;
};

/// The one through three points, in order of place; nothing if it has no lowest place.
inline std::optional<Parabola> ParabolaThrough(const std::array<ParabolaPoint, 3>& points) {
  const auto& [a, b, c] = points;
  const double first = (b.value - a.value) / (b.at - a.at), second = (c.value - b.value) / (c.at - b.at),
               bend = 2 * (second - first) / (c.at - a.at);
  if (!(bend > 0)) return std::nullopt;
  return Parabola{(a.at + b.at) / 2 - first / bend, bend};
}

}  // namespace chequer
