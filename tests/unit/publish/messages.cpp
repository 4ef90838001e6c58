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

}  // namespace chequer::test
