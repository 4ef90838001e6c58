#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/race.h"

namespace chequer::bench {

/// A suite's results as a table for people. With `by_condition`, a line a condition as well.
std::string FormatTable(const Suite& suite, const std::vector<Result>& results, bool by_condition);

/// The same for programs: {"suite", "side_m", "width", "height", "detectors": [{"name", "frames", "ms", "markers",
/// "recall", "wrong", "undecided", "pose"?, "conditions": [{"condition", "markers", …, "track"?}]}]}; millimetres and
/// degrees. What could not be measured is left out.
nlohmann::json ToJson(const Suite& suite, const std::vector<Result>& results);

/// The processor's name and the versions of what is compared.
nlohmann::json DescribeMachine();

}  // namespace chequer::bench
