#pragma once

#include <span>
#include <string>
#include <vector>

#include "golden/scene_file.h"

namespace chequer::golden {

/// What a scene's detections are worth.
struct Verdict {
  int expected = 0;   ///< markers in the frames
  int detected = 0;   ///< of them, found with the right id
  int undecided = 0;  ///< boards found in the right place whose identity was left open
  double worst_corner_px = 0;
  double worst_position_mm = 0;
  double worst_angle_deg = 0;
  std::vector<std::string> failures;  ///< wrong detections and breaches of tolerances, one a line
};

/// Holds the detections of one frame against what is in it, and adds to the verdict. A detection with another id than
/// the marker's in its place, or of nothing that is there, is a failure; so is a board without an id where no marker
/// is.
void JudgeFrame(const GoldenScene& scene, const ExpectedFrame& frame, std::span<const MarkerPose> detections,
                Verdict& verdict);

/// Adds the failure of finding too few in all frames.
void JudgeCount(const GoldenScene& scene, Verdict& verdict);

}  // namespace chequer::golden
