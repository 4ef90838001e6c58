#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"
#include "publish/publisher.h"
#include "robot/robot_finder.h"
#include "track/tracker.h"
#include "world/drift_monitor.h"
#include "world/world_file.h"

namespace chequer {

/// In which frame of reference poses are published where the world is known.
enum class PublishedFrames : std::uint8_t {
  kWorld,
  kCamera,  ///< as if there were no world; robots and tracks are in the world all the same
  kBoth,    ///< in the world, and once more in the camera's on a channel of their own
};

/// The time that published tracks hold for.
enum class TrackTime : std::uint8_t { kCapture, kPublish };

struct FramePublisherOptions {
  std::optional<WorldCalibration> world{};
  PublishedFrames frames = PublishedFrames::kWorld;
  DriftOptions drift{};

  std::optional<RobotRoster> roster{};
  bool ignore_others = false;  ///< markers with an id that no robot of the roster bears are not published
  bool floor_mode = false;
  double max_height_error_m = RobotFinderOptions{}.max_height_error_m;
  double max_tilt_rad = RobotFinderOptions{}.max_tilt_rad;

  bool tracks = false;
  TrackerOptions tracker{};
  TrackTime track_time = TrackTime::kCapture;
};

/// Makes of one frame's markers all messages it is published as: poses in the frames of reference that are wanted, the
/// robots of the roster, and the tracks. Poses are published as they were measured, whatever the tracks make of them.
/// Frames must come in the order of capture. One thread.
class FramePublisher {
 public:
  /// Throws std::runtime_error where the options are not valid.
  explicit FramePublisher(FramePublisherOptions options);

  /// @param message in the camera's frame of reference; changed on the way.
  void Publish(PosesMessage& message, Publisher& publisher, const Clock& clock);

  /// What is wrong with the world now: that its references moved; empty where nothing is.
  const std::string& trouble() const { return trouble_; }
  /// Since the last call: "outside_roster", "robots", "off_floor", "tracks"; of what is configured.
  std::vector<NamedCount> TakeCounts();

 private:
  void WatchWorld(const PosesMessage& message);
  void LeaveOutOthers(std::vector<MarkerPose>& markers);
  void PublishPoses(PosesMessage& message, Publisher& publisher);
  FrameHeader HeaderOf(const PosesMessage& message, const Clock& clock) const;
  /// Poses for the tracks: of the robots, or without a roster of every marker.
  void Collect(std::span<const MarkerPose> markers);
  void Follow(const FrameHeader& header, const Clock& clock);

  FramePublisherOptions options_;
  std::optional<RobotFinder> finder_;
  std::optional<Tracker> tracker_;
  std::optional<DriftMonitor> monitor_;
  RobotsMessage robots_;
  TracksMessage tracks_;
  PosesMessage in_world_;
  std::vector<TrackedPose> followed_;
  std::string trouble_;
  std::uint64_t outside_roster_ = 0, robot_count_ = 0, off_floor_ = 0, track_count_ = 0;
};

/// The same marker in another frame of reference: position, orientation and covariance turned and moved.
void MoveInto(const RigidTransform& target_from_camera, MarkerPose& marker);

/// A robot's pose as its track takes it: from the floor where it stands on it, else free.
TrackedPose ToTrack(const RobotPose& robot);

}  // namespace chequer
