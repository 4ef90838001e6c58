#include "world/side_check.h"

#include <algorithm>
#include <cmath>

#include "core/length.h"

namespace chequer {
namespace {

/// Two people with rulers differ by less; what is printed at another scale differs by more.
constexpr double kMostRelativeDifference = 0.02;

bool MayBear(const MarkerFamily& family, const WorldReference& reference) {
  const bool in_use = family.roster.empty() ||
                      std::find(family.roster.begin(), family.roster.end(), reference.id) != family.roster.end();
  return in_use && family.code.size() == reference.size && family.code.variant() == reference.variant;
}

}  // namespace

std::string SideContradiction(const WorldCalibration& world, std::span<const MarkerFamily> families) {
  for (const WorldReference& reference : world.references) {
    const MarkerFamily* other = nullptr;
    bool agrees = false;
    for (const MarkerFamily& family : families) {
      if (!MayBear(family, reference)) continue;
      if (std::abs(family.side_m - reference.side_m) <= kMostRelativeDifference * reference.side_m)
        agrees = true;
      else
        other = &family;
    }
    if (agrees || other == nullptr) continue;
    return "the side of the markers is " + LengthText(other->side_m) + " here, but " + LengthText(reference.side_m) +
           " in the world file (reference " + std::to_string(reference.id) + ", " + ToString(reference.size) + " " +
           std::string(VariantName(reference.variant)) +
           "): one of them is wrong, and distances with it; measure a print, then correct the side, or run chequer "
           "calibrate world again";
  }
  return {};
}

}  // namespace chequer
