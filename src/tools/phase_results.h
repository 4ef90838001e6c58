#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluate/phase_score.h"

namespace chequer {

/// A run over a recorded stream.
struct PhaseRun {
  std::string name;  ///< the results' file
  std::vector<ScoredFrame> frames;
};

/// Compares results with the truth of the recording that they are of, frame by frame. Results are what `chequer detect
/// --json` printed, or a log of lcm-logger, in which the recording may be played over and over. Throws
/// std::runtime_error naming the file and what is wrong, also where a result is of no frame of the recording, or where
/// poses are given in another frame of reference than the camera's.
/// @param channel of a log that holds the poses of several cameras; empty: the only one.
PhaseRun ReadPhaseRun(const std::filesystem::path& results, const std::filesystem::path& recording,
                      const std::string& channel);

}  // namespace chequer
