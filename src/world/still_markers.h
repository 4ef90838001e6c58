#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "chequer/detector.h"
#include "chequer/geometry.h"

namespace chequer {

/// A marker that stands still, as a camera that stands still saw it in several frames.
struct StillMarker {
  std::uint64_t id = 0;
  int family = 0;
  MarkerSize size;
  Variant variant = Variant::kSecded;
  RigidTransform camera_from_marker;  ///< mean over the frames
  /// Of the mean, as MarkerPose::covariance.
  Matrix6d covariance = Matrix6d::Zero();
  int frames = 0;
  /// Largest distance of a pose from the mean, across the line of sight, metres: what shows that it moved.
  double spread_m = 0;
};

/// Collects the poses of markers over frames.
class StillMarkers {
 public:
  /// Takes the markers of one frame; those without id or pose are passed over.
  void Add(std::span<const MarkerPose> markers);

  int frames() const { return frames_; }
  /// One for each marker that was seen, by family and id.
  std::vector<StillMarker> Means() const;

 private:
  using Key = std::tuple<int, std::uint64_t>;
  std::map<Key, std::vector<MarkerPose>> poses_;
  int frames_ = 0;
};

}  // namespace chequer
