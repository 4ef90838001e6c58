#include "unit/publish/messages.h"

namespace chequer::test {
namespace {

using std::chrono::microseconds;

MarkerPose SampleMarker(std::uint64_t id) {
  MarkerPose marker;
  marker.id = id;
  marker.family = 3;
  marker.variant = Variant::kGolay;
  marker.size = {8, 7};
  marker.has_pose = true;
  marker.camera_from_marker = {RotationFromVector({0.1, -0.2, 0.3}), {0.25, -0.5, 3.0}};
  for (int row = 0; row < 6; ++row)
    for (int col = 0; col < 6; ++col)
      marker.covariance(row, col) = 1e-9 * (1 + std::min(row, col) * 6 + std::max(row, col));
  marker.ambiguity = 0.125;
  marker.corners.fill({1.5F, 2.5F});
  marker.corners_used = 41;
  marker.reprojection_rms_px = 0.0625;
  marker.center_px = {320.5, 240.25};
  marker.luminance_overlap = 0.03125;
  marker.saturation_overlap = 0.015625;
  marker.bits_corrected = 2;
  marker.warnings =
      static_cast<std::uint32_t>(Warning::kPartlyHidden) | static_cast<std::uint32_t>(Warning::kAmbiguous);
  return marker;
}

FrameHeader SampleHeader() {
  const PosesMessage frame = SamplePoses(0);
  return {frame.captured_utc,        frame.captured_monotonic, frame.instant, frame.published_utc,
          frame.published_monotonic, frame.sequence,           frame.camera,  "world"};
}

}  // namespace

PosesMessage SamplePoses(std::size_t markers) {
  PosesMessage message;
  message.captured_utc = UtcTime(microseconds(1'700'000'000'123'456));
  message.captured_monotonic = MonotonicTime(microseconds(42'000'001));
  message.instant = ExposureInstant::kMiddle;
  message.published_utc = UtcTime(microseconds(1'700'000'000'130'000));
  message.published_monotonic = MonotonicTime(microseconds(42'006'545));
  message.sequence = 1234567;
  message.frames_dropped = 89;
  message.camera = "ceiling";
  message.frame = "camera";
  message.image_width = 1920;
  message.image_height = 1080;
  for (std::size_t i = 0; i < markers; ++i) message.markers.push_back(SampleMarker(i));
  return message;
}

StatusMessage SampleStatus() {
  StatusMessage message;
  message.utc = UtcTime(microseconds(1'700'000'001'000'000));
  message.monotonic = MonotonicTime(microseconds(43'000'000));
  message.uptime = microseconds(7'000'000);
  message.version = "1.2.3";
  message.camera = "ceiling";
  message.camera_state = CameraState::kEnded;
  message.camera_source = "recording /data/swarm";
  message.camera_message = "over";
  message.publisher = {PublisherState::kFailing, "no route", 11, 12};
  message.window = microseconds(1'000'000);
  message.capture_rate_hz = 60.5;
  message.publish_rate_hz = 59.5;
  message.frames_captured = 421;
  message.frames_published = 420;
  message.frames_dropped = 4;
  message.queue_depth = 1;
  message.queue_capacity = 2;
  message.workers = 3;
  message.markers_mean = 49.5;
  message.markers_min = 48;
  message.markers_max = 50;
  message.drops = {{"corrupt", 1}, {"superseded", 3}};
  message.stages = {{"detect", 60, microseconds(5000), microseconds(7000), microseconds(9000)}};
  message.detections = {{"boards", 3000}};
  return message;
}

RobotsMessage SampleRobots(std::size_t robots) {
  RobotsMessage message{SampleHeader(), {}};
  for (std::size_t i = 0; i < robots; ++i) {
    const MarkerPose marker = SampleMarker(i);
    RobotPose robot;
    robot.name = "robot " + std::to_string(i);
    robot.ids = {i, i + 100};
    robot.marker_count = 2;
    robot.family = 1;
    robot.frame_from_body = marker.camera_from_marker;
    robot.covariance = marker.covariance;
    robot.ambiguity = 0.25;
    FloorPose floor{.position = {1.5, -2.5}, .heading_rad = 0.75};
    floor.covariance << 1, 2, 3, 2, 4, 5, 3, 5, 6;
    floor.height_error_m = 0.125;
    floor.tilt_rad = 0.375;
    floor.chi_square = 77;
    floor.off_floor = true;
    robot.floor = floor;
    message.robots.push_back(robot);
  }
  return message;
}

TracksMessage SampleTracks(std::size_t tracks) {
  TracksMessage message{
      SampleHeader(), UtcTime(microseconds(1'700'000'000'131'000)), MonotonicTime(microseconds(42'007'545)), {}};
  for (std::size_t i = 0; i < tracks; ++i) {
    TrackState track;
    track.key = {"robot " + std::to_string(i), 2, i};
    track.frame_from_body = {RotationFromVector({0, 0, 0.5}), {0.25, -0.5, 3.0}};
    track.velocity = {0.5, -0.25, 0.125};
    track.angular_velocity = {0.0625, 0.03125, 1.5};
    for (int row = 0; row < 12; ++row)
      for (int col = 0; col < 12; ++col) track.covariance(row, col) = 1 + std::min(row, col) * 12 + std::max(row, col);
    track.age = microseconds(5'000'000);
    track.since_seen = microseconds(40'000);
    track.coasting = true;
    track.poses_used = 99;
    track.poses_refused = 3;
    message.tracks.push_back(track);
  }
  return message;
}

}  // namespace chequer::test
