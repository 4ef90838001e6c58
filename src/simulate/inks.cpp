#include "simulate/inks.h"

#include <array>
#include <utility>

#include "chequer/check.h"

namespace chequer {
namespace {

// Reflectances are guesses from published print measurements (ISO 12647 solids on uncoated paper), rounded; what
// matters to a detector is their order: blue is nearly black in red, yellow nearly white in red and green.
const std::array<std::pair<std::string_view, InkSet>, 5>& Sets() {
  static const std::array<std::pair<std::string_view, InkSet>, 5> kSets{{
      {"laser", InkSet{}},
      {"inkjet", {{0.050f, 0.048f, 0.052f}, {0.84f, 0.85f, 0.87f}, {0.055f, 0.080f, 0.300f}, {0.740f, 0.640f, 0.090f}}},
      {"matte", {{0.090f, 0.088f, 0.090f}, {0.72f, 0.71f, 0.68f}, {0.085f, 0.120f, 0.290f}, {0.620f, 0.520f, 0.120f}}},
      {"faded", {{0.070f, 0.070f, 0.072f}, {0.82f, 0.81f, 0.76f}, {0.120f, 0.170f, 0.310f}, {0.760f, 0.690f, 0.280f}}},
      {"ideal", {{0, 0, 0}, {1, 1, 1}, {0, 0, 1}, {1, 1, 0}}},
  }};
  return kSets;
}

}  // namespace

const Eigen::Vector3f& InkSet::Of(char colour) const {
  switch (colour) {
    case 'K': return black;
    case 'W': return white;
    case 'B': return blue;
    case 'Y': return yellow;
    default: FailCheck("colour is one of K, W, B, Y", __FILE__, __LINE__, "unknown cell colour");
  }
}

std::string InkSet::Check() const {
  for (const char colour : {'K', 'W', 'B', 'Y'}) {
    const Eigen::Vector3f& ink = Of(colour);
    if (!(ink.minCoeff() >= 0) || !(ink.maxCoeff() <= 1))
      return std::string("the reflectances of ink ") + colour + " must be from 0 to 1";
  }
  return {};
}

std::optional<InkSet> NamedInks(std::string_view name) {
  for (const auto& [known, inks] : Sets())
    if (known == name) return inks;
  return std::nullopt;
}

std::string InkNames() {
  std::string text;
  for (const auto& [name, inks] : Sets()) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

}  // namespace chequer
