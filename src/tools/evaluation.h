#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evaluate/recognition.h"
#include "evaluate/track.h"
#include "tools/run_file.h"

namespace chequer {

/// How well the marker of a run was seen.
struct Evaluation {
  std::string name;
  Recognition recognition;
  std::optional<TrackFit> track;  ///< where there are at least three poses
  int poses = 0;
  std::vector<std::uint64_t> others;  ///< ids of further markers that are there; they are not counted as wrong
  std::string objection;              ///< why the run is none that can be evaluated whole; empty where it is
  ErrorMeasures linear_mm;            ///< distances from the best line
  ErrorMeasures angular_deg;          ///< angles to the best constant orientation
};

/// Evaluates the marker of that id; of the one that was read most often where there is none. Throws std::runtime_error
/// naming the run where no id was read at all.
Evaluation Evaluate(const Run& run, std::optional<std::uint64_t> id);

/// Lines for people, ending with a line's end.
std::string Describe(const Evaluation& evaluation);

/// One line of JSON without its end: {"run", "id", "frames", "recognised", "recognition_rate", "undecided", "wrong",
/// "poses", "track": {"length_m", "point", "direction", "orientation"}, "linear_mm": {"rmse", "mae", "largest",
/// "printed_rmse", "printed_mae", "errors"}, "angular_deg": {…}, "along_m"}; what needs three poses is left out where
/// there are fewer, and what a straight track where it is none; then "objection" says why. "others": ids beside it.
std::string JsonLine(const Evaluation& evaluation);

}  // namespace chequer
