#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "chequer/frame.h"
#include "core/track_state.h"
#include "track/constant_velocity.h"

namespace chequer {

struct TrackerOptions {
  MotionModel model{};
  /// Poses farther from where the robot could be than so many standard deviations are refused, 2..100. The default lets
  /// one honest pose in a hundred millions go.
  double gate = 7;
  /// A track without a pose for so long ends, 0.01..60 s.
  std::chrono::milliseconds coast{500};
  /// After so many refused poses on end that agree with each other the robot was carried elsewhere: its track begins
  /// anew there. 2..1000.
  int refused_to_restart = 5;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// One robot's pose in one frame, as measured.
struct TrackedPose {
  TrackKey key;
  RigidTransform frame_from_body;
  Matrix6d covariance = Matrix6d::Zero();  ///< as RobotPose::covariance; positive definite
  /// The part of it that stays from frame to frame: the filter does not average it away.
  Matrix6d print_covariance = Matrix6d::Zero();
};

/// Follows every robot by a filter of its own. One thread.
class Tracker {
 public:
  /// Throws std::runtime_error with TrackerOptions::Check's message.
  explicit Tracker(TrackerOptions options = {});

  /// Takes all poses of one frame. Where one robot stands in it twice, the pose nearer to its track is taken. Poses
  /// whose numbers are not finite are passed over. A time before the last one (a recording begins again) ends all
  /// tracks.
  void Update(std::span<const TrackedPose> poses, MonotonicTime captured);

  /// The tracks as they are at a time, in the order of their keys; at the last frame's or later: moved on till then.
  void Tracks(MonotonicTime at, std::vector<TrackState>& tracks) const;

 private:
  struct Track {
    TrackKey key;
    ConstantVelocity filter;  ///< of what varies from frame to frame
    Matrix6d print_covariance = Matrix6d::Zero();  ///< by the last pose that was believed: what does not
    MonotonicTime first_seen, last_seen;
    std::uint64_t poses_used = 1, poses_refused = 0;
    int refused_on_end = 0;
    std::optional<ConstantVelocity> elsewhere{};  ///< where refused poses say it is
  };

  /// Where a key stands or belongs.
  std::vector<Track>::iterator PlaceOf(const TrackKey& key);
  Track* Find(const TrackKey& key);
  void Take(Track& track, const TrackedPose& pose);
  void Refuse(Track& track, const TrackedPose& pose);

  TrackerOptions options_;
  std::vector<Track> tracks_;  ///< by key
  std::optional<MonotonicTime> time_;
};

}  // namespace chequer
