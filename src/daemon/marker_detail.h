#pragma once

#include <memory>
#include <vector>

#include "chequer/detector.h"
#include "publish/view_messages.h"

namespace chequer {

/// The marker of those that is meant; null where it is not among them. One without an id is the nearest, at most
/// kNearestPx away.
const MarkerPose* FindChoice(const MarkerChoice& choice, const std::vector<MarkerPose>& markers);

/// Shows what the detector sees of one marker: detects it once more, in the part of the frame around it alone, with a
/// trace. What it takes is bounded. One thread.
class MarkerDetail {
 public:
  /// @param options of the pipeline's detectors.
  explicit MarkerDetail(const DetectorOptions& options);

  /// @param seen the marker, as it was found in this image. Leaves out what a message of the daemon begins with.
  DetailMessage Look(const ImageView& image, const MarkerPose& seen);

 private:
  Detector detector_;
  std::vector<MarkerPose> markers_;
};

}  // namespace chequer
