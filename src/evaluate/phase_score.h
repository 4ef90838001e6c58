#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evaluate/frame_score.h"

namespace chequer {

/// A frame of a run over a stream, in the order of the stream.
struct ScoredFrame {
  std::string phase;
  double time_s = 0;  ///< since the run's first frame; grows also where the stream is played over and over
  std::optional<FrameScore> score;  ///< empty where nothing came of the frame
  std::optional<double> detect_ms;
  std::optional<double> latency_ms;
};

/// What some numbers are like; all 0 where there are none.
struct Spread {
  std::size_t count = 0;
  double median = 0;
  double p99 = 0;
  double largest = 0;
  double mean = 0;
  double rms = 0;
};
Spread SpreadOf(std::vector<double> values);

/// All frames of a phase.
struct PhaseScore {
  std::string name;
  int frames = 0;    ///< of the stream
  int missing = 0;   ///< nothing came of them; they count nowhere else
  FrameScore total;  ///< its errors are left out: they are below
  Spread position_mm, angle_deg;
  Spread position_over_covariance, rotation_over_covariance;
  /// Of poses with a carried id, which the others leave out.
  Spread carried_position_mm, carried_position_over_covariance;
  Spread detect_ms, latency_ms;
};

/// One entry a phase, in the order in which they first come.
std::vector<PhaseScore> ScorePhases(std::span<const ScoredFrame> frames);

/// All frames as one phase of that name.
PhaseScore ScoreAll(std::span<const ScoredFrame> frames, const std::string& name);

}  // namespace chequer
