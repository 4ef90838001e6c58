#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/detector.h"
#include "chequer/frame.h"
#include "core/robot_pose.h"
#include "core/track_state.h"

namespace chequer {

/// What all messages of a frame begin with.
struct FrameHeader {
  UtcTime captured_utc{};  ///< of the instant that `instant` names
  MonotonicTime captured_monotonic{};
  ExposureInstant instant = ExposureInstant::kUnknown;
  UtcTime published_utc{};
  MonotonicTime published_monotonic{};
  std::uint64_t sequence = 0;  ///< always rising; a gap is frames that were lost
  std::string camera;
  std::string frame = "camera";  ///< frame of reference of the poses
};

/// What one frame says: poses_t without LCM. Its markers' camera_from_marker holds frame_from_marker.
struct PosesMessage : FrameHeader {
  std::uint64_t frames_dropped = 0;  ///< since the start, for any reason
  int image_width = 0;               ///< pixels
  int image_height = 0;
  /// Their corners do not travel: in a received message all are NaN.
  std::vector<MarkerPose> markers;
};

/// The robots of the roster that one frame shows: robots_t without LCM.
struct RobotsMessage {
  FrameHeader header;
  std::vector<RobotPose> robots;
};

/// The tracks after one frame: tracks_t without LCM.
struct TracksMessage {
  FrameHeader header;
  UtcTime valid_utc{};  ///< when the tracks hold
  MonotonicTime valid_monotonic{};
  std::vector<TrackState> tracks;
};

enum class CameraState : std::uint8_t { kWaiting, kRunning, kEnded };
enum class PublisherState : std::uint8_t { kWaiting, kReady, kFailing };

struct NamedCount {
  std::string name;
  std::uint64_t count = 0;
};

/// Latency of one stage over a window; the times are meaningful where frames > 0.
struct StageLatency {
  std::string stage;
  std::uint64_t frames = 0;
  std::chrono::microseconds median{};
  std::chrono::microseconds p99{};
  std::chrono::microseconds worst{};
};

/// How the publisher fares.
struct PublisherHealth {
  PublisherState state = PublisherState::kWaiting;
  std::string message;       ///< what is wrong and what would help; empty where nothing is wrong
  std::uint64_t sent = 0;    ///< messages LCM took
  std::uint64_t failed = 0;  ///< messages it did not; they are gone
};

/// StatusMessage::detections counts the markers that carried a warning under this and the warning's name.
inline constexpr std::string_view kWarningCountPrefix = "warning_";
/// Of the counts that say why markers are not read.
inline constexpr std::string_view kHintPrefix = "hint_";

/// How the daemon fares: status_t without LCM. Fields as documented in lcmtypes/status_t.lcm.
struct StatusMessage {
  UtcTime utc{};
  MonotonicTime monotonic{};
  std::chrono::microseconds uptime{};
  std::string version;
  std::string camera;
  CameraState camera_state = CameraState::kWaiting;
  std::string camera_source;
  std::string camera_message;
  PublisherHealth publisher;
  std::chrono::microseconds window{};
  double capture_rate_hz = 0;
  double publish_rate_hz = 0;
  std::uint64_t frames_captured = 0;
  std::uint64_t frames_published = 0;
  std::uint64_t frames_dropped = 0;
  int queue_depth = 0;
  int queue_capacity = 0;
  int workers = 0;
  double markers_mean = 0;
  int markers_min = 0;
  int markers_max = 0;
  std::vector<NamedCount> drops;
  std::vector<StageLatency> stages;
  std::vector<NamedCount> detections;
};

}  // namespace chequer
