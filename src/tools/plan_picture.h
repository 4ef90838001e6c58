#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/plan_estimate.h"

namespace chequer {

/// A PNG for a screen: one marker as the camera would see it, enlarged; what the image shows of the plane, with markers
/// in proportion; and the lines of the verdict. Throws std::runtime_error where drawing fails.
std::vector<std::uint8_t> DrawPlan(const PlanScene& scene, const PlanEstimate& estimate,
                                   const std::vector<std::string>& lines);

}  // namespace chequer
