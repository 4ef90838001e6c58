#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "chequer/camera_model.h"
#include "tools/calibration_watch.h"
#include "world/estimate.h"
#include "world/still_markers.h"

namespace chequer {

/// An estimate with the markers that its residuals number.
struct WorldResult {
  WorldEstimate estimate;
  std::vector<StillMarker> markers;
};

/// Shows the calibration of the world while it runs (CalibrationWatch): which references are seen, and, as far as they
/// suffice, how each agrees with the rest.
class WorldProgress {
 public:
  /// Throws std::runtime_error where the markers do not suffice.
  using Solver = std::function<WorldResult(const std::vector<StillMarker>&)>;

  /// @param wanted ids of the references.
  WorldProgress(const std::optional<CameraSetup>& setup, const CameraModel& camera, std::vector<std::uint64_t> wanted,
                Solver solve);

  /// After each frame.
  void Look(const StillMarkers& still, int frames_wanted);
  void Finish(const WorldResult& result);
  void Fail(const std::string& why);

 private:
  void TakeSeen(const std::vector<StillMarker>& seen);
  void TakeResult(const WorldResult& result);

  CalibrationWatch watch_;
  CameraModel camera_;
  std::vector<std::uint64_t> wanted_;
  Solver solve_;
  CalibrationMessage message_;
};

}  // namespace chequer
