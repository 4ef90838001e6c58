#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/race.h"

namespace chequer::bench {

/// A suite's results as a table for people; "times" is the time against that of the first. With `by_condition`, a line
/// a condition as well; where its frames' noise is known, with what is possible at best in a line above, and how many
/// times that each of our errors is.
std::string FormatTable(const Suite& suite, const std::vector<Result>& results, bool by_condition);

/// The same for programs: {"suite", "side_m", "width", "height", "detectors": [{"name", "frames", "ms", "markers",
/// "recall", "wrong", "undecided", "pose"?, "conditions": [{"condition", "markers", …, "track"?}]}], "bounds":
/// {CONDITION: {"position_rms_mm", "angle_rms_deg", "linear_rms_mm", "angular_rms_deg"}}}; millimetres and degrees.
/// What could not be measured is left out.
nlohmann::json ToJson(const Suite& suite, const std::vector<Result>& results);

/// The processor's name and the versions of what is compared.
nlohmann::json DescribeMachine();

}  // namespace chequer::bench
