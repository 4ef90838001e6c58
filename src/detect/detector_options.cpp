#include <algorithm>
#include <string>

#include "chequer/detector.h"

namespace chequer {

std::string DetectorOptions::Check() const {
  if (families.empty()) return "no marker family: at least one size, variant and side must be given";
  for (const MarkerFamily& family : families)
    if (camera && !(family.side_m > 0 && family.side_m < 100))
      return "marker side " + std::to_string(family.side_m) + " m: must be above 0 and below 100 m";
  if (!(max_luminance_overlap >= 0 && max_luminance_overlap <= 0.5))
    return "max_luminance_overlap: must be from 0 to 0.5";
  if (!(max_saturation_overlap >= 0 && max_saturation_overlap <= 0.5))
    return "max_saturation_overlap: must be from 0 to 0.5";
  for (const MarkerFamily& family : families) {
    const bool each_is_print = std::all_of(family.printed_by_id_m.begin(), family.printed_by_id_m.end(),
                                           [&](const auto& print) { return family.IsPrint(print.second); });
    if (!each_is_print || !(family.printed_m.isZero() || family.IsPrint(family.printed_m)))
      return "marker width and height: must be above 0, and those of nearly square cells";
  }
  if (!(print_tolerance.scale >= 0 && print_tolerance.scale <= 0.05))
    return "print tolerance: scale must be from 0 to 0.05";
  if (!(print_tolerance.register_m >= 0 && print_tolerance.register_m <= 0.005))
    return "print tolerance: register must be from 0 to 5 mm";
  if (threads < 1 || threads > 64) return "threads: must be from 1 to 64";
  if (budget != 0 && budget < kLeastBudget)
    return "budget " + std::to_string(budget) + ": must be 0, for no limit, or at least " +
           std::to_string(kLeastBudget);
  if (search_every < 1 || search_every > 64) return "search_every: must be from 1 to 64";
  if (!(carry_s >= 0 && carry_s <= 60)) return "carry_s: must be from 0 to 60";
  return "";
}

std::string_view WarningName(Warning warning) {
  switch (warning) {
    case Warning::kIdUndecided: return "id_undecided";
    case Warning::kPoorIllumination: return "poor_illumination";
    case Warning::kPoorWhiteBalance: return "poor_white_balance";
    case Warning::kPartlyHidden: return "partly_hidden";
    case Warning::kAmbiguous: return "ambiguous_pose";
    case Warning::kIdCarried: return "id_carried";
    case Warning::kPoorFit: return "poor_fit";
    case Warning::kLevelsLearnt: return "levels_learnt";
  }
  return "";
}

}  // namespace chequer
