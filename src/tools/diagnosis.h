#pragma once

#include <span>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "chequer/image.h"
#include "tools/finding.h"

namespace chequer {

/// Tries on an image what was not sought: all sizes, all variants, mirror images, ids beyond the roster, and whether
/// the picture is black, blurred or without contrast. What of it explains markers that were not read, or were read as
/// another's, with what would help. Takes several times as long as a detection.
/// @param image BGR8. @param sought as the detection was asked for. @param markers, trace what it gave.
std::vector<Finding> Diagnose(const ImageView& image, const DetectorOptions& sought,
                              std::span<const MarkerPose> markers, const DetectTrace& trace);

}  // namespace chequer
