#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "chequer/marker.h"

namespace chequer {

/// Every variant with its name, in the order of Variant.
inline constexpr std::array<std::pair<std::string_view, Variant>, 8> kVariants{
    {{"unconstrained", Variant::kUnconstrained},
     {"saturation_constrained", Variant::kSaturationConstrained},
     {"color_constrained", Variant::kColorConstrained},
     {"secded", Variant::kSecded},
     {"golay", Variant::kGolay},
     {"nordstrom_robinson", Variant::kNordstromRobinson},
     {"reed_muller", Variant::kReedMuller},
     {"table", Variant::kTable}}};

}  // namespace chequer
