#pragma once

#include <map>
#include <string>
#include <vector>

#include "bench/frames.h"
#include "bench/peer.h"
#include "bench/score.h"

namespace chequer::bench {

/// What one contestant did in one suite.
struct Result {
  std::string contestant;
  int frames = 0;
  /// Of the fastest repetition of each frame: their median, or of a stream MeanOfStream.
  double ms = 0;
  Score total;                                            ///< over all conditions; its track means nothing
  std::vector<std::pair<std::string, Score>> conditions;  ///< in the order of frames
};

/// Runs every contestant on the frames of its pattern. They take turns frame by frame, each repetition in another
/// order, so that a machine that slows down hits all alike. Marker-free suites show everyone the same frames.
std::vector<Result> Race(const Suite& suite, int repetitions, const std::vector<Peer>& peers);

}  // namespace chequer::bench
