#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "chequer/detector.h"
#include "chequer/frame.h"
#include "world/world_file.h"

namespace chequer {

struct DriftOptions {
  /// Displacement of a reference that is warned of, metres at the reference, 0.0001..10.
  double limit_m = 0.005;
  /// Displacements are averaged over about that long, so that one bad pose warns of nothing.
  std::chrono::milliseconds window{2000};

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// How far one reference is from where it stood when the world was set.
struct ReferenceDrift {
  std::uint64_t id = 0;
  bool in_view = false;    ///< seen within the last window; what follows says nothing if not
  bool has_moved = false;  ///< offset_m went above the limit and has not come well below it since
  /// Across the line of sight, root mean square over the board's outer corners, averaged, metres. A single frame counts
  /// at most three times the limit.
  double offset_m = 0;
  /// Natural logarithm of how many times as far away as then it looks, averaged.
  double farther_log = 0;
  /// How far its centre is beside its old line of sight, averaged, metres.
  double beside_m = 0;
};

/// Notices that the camera was knocked, a reference moved, or the side of the markers is wrong, from the references
/// that stay in view. One thread.
class DriftMonitor {
 public:
  /// Throws std::runtime_error with DriftOptions::Check's message. Without references it never warns.
  explicit DriftMonitor(WorldCalibration world, DriftOptions options = {});

  /// Takes the markers of one frame, with poses in the camera frame; others than the references are passed over. Frames
  /// must come in the order of their times. Returns what to log where something has changed: that references have moved
  /// and which (a knocked camera moves them all), that a wrong side makes them look nearer or farther, or that they are
  /// back in their places. Nothing otherwise.
  std::optional<std::string> Take(std::span<const MarkerPose> markers, MonotonicTime captured);

  /// Whether a reference that is in view has moved, or the side is wrong.
  bool has_drifted() const { return !moved_.empty() || has_wrong_side_; }
  /// In the order of WorldCalibration::references.
  const std::vector<ReferenceDrift>& drifts() const { return drifts_; }

 private:
  /// What one frame says of one reference.
  struct Sample {
    double offset_m = 0, farther_log = 0, beside_m = 0;
  };
  Sample Measure(const WorldReference& reference, const RigidTransform& camera_from_marker) const;
  void Average(std::size_t reference, const Sample& sample, MonotonicTime captured);
  std::optional<std::string> Judge(MonotonicTime now);
  /// By how many times all references in view look farther away, each in its old direction; 1 where they do not.
  double CommonScale() const;
  std::string Warning() const;
  std::string SideWarning(double scale) const;

  WorldCalibration world_;
  RigidTransform camera_from_world_;
  DriftOptions options_;
  std::vector<ReferenceDrift> drifts_;
  std::vector<std::optional<MonotonicTime>> last_seen_;  ///< by reference
  std::vector<double> scale_weights_;                    ///< by reference: share of its average that frames filled
  std::vector<std::size_t> moved_;                       ///< those in view that have moved, as last told
  bool has_wrong_side_ = false;                          ///< as last reported
};

}  // namespace chequer
