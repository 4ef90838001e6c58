#include "publish/wire.h"

#include <algorithm>
#include <chequer/poses_t.hpp>
#include <chequer/status_t.hpp>
#include <exception>
#include <limits>

#include "chequer/check.h"
#include "publish/wire_header.h"
#include "publish/wire_robots.h"
#include "publish/wire_values.h"

namespace chequer {
namespace {

// The numbers on the wire are for ever; those of the program could be reordered.
static_assert(static_cast<int>(Variant::kUnconstrained) == marker_pose_t::VARIANT_UNCONSTRAINED);
static_assert(static_cast<int>(Variant::kSaturationConstrained) == marker_pose_t::VARIANT_SATURATION_CONSTRAINED);
static_assert(static_cast<int>(Variant::kColorConstrained) == marker_pose_t::VARIANT_COLOR_CONSTRAINED);
static_assert(static_cast<int>(Variant::kSecded) == marker_pose_t::VARIANT_SECDED);
static_assert(static_cast<int>(Variant::kGolay) == marker_pose_t::VARIANT_GOLAY);
static_assert(static_cast<int>(Variant::kNordstromRobinson) == marker_pose_t::VARIANT_NORDSTROM_ROBINSON);
static_assert(static_cast<int>(Variant::kReedMuller) == marker_pose_t::VARIANT_REED_MULLER);
static_assert(static_cast<int>(Variant::kTable) == marker_pose_t::VARIANT_TABLE);
static_assert(static_cast<int>(Warning::kIdUndecided) == marker_pose_t::WARNING_ID_UNDECIDED);
static_assert(static_cast<int>(Warning::kPoorIllumination) == marker_pose_t::WARNING_POOR_ILLUMINATION);
static_assert(static_cast<int>(Warning::kPoorWhiteBalance) == marker_pose_t::WARNING_POOR_WHITE_BALANCE);
static_assert(static_cast<int>(Warning::kPartlyHidden) == marker_pose_t::WARNING_PARTLY_HIDDEN);
static_assert(static_cast<int>(Warning::kAmbiguous) == marker_pose_t::WARNING_AMBIGUOUS_POSE);
static_assert(static_cast<int>(Warning::kIdCarried) == marker_pose_t::WARNING_ID_CARRIED);
static_assert(static_cast<int>(Warning::kPoorFit) == marker_pose_t::WARNING_POOR_FIT);
static_assert(static_cast<int>(Warning::kLevelsLearnt) == marker_pose_t::WARNING_LEVELS_LEARNT);
static_assert(static_cast<int>(ExposureInstant::kUnknown) == poses_t::INSTANT_UNKNOWN);
static_assert(static_cast<int>(ExposureInstant::kStart) == poses_t::INSTANT_START);
static_assert(static_cast<int>(ExposureInstant::kMiddle) == poses_t::INSTANT_MIDDLE);
static_assert(static_cast<int>(ExposureInstant::kEnd) == poses_t::INSTANT_END);
static_assert(static_cast<int>(CameraState::kWaiting) == status_t::CAMERA_WAITING);
static_assert(static_cast<int>(CameraState::kRunning) == status_t::CAMERA_RUNNING);
static_assert(static_cast<int>(CameraState::kEnded) == status_t::CAMERA_ENDED);
static_assert(static_cast<int>(PublisherState::kWaiting) == status_t::PUBLISHER_WAITING);
static_assert(static_cast<int>(PublisherState::kReady) == status_t::PUBLISHER_READY);
static_assert(static_cast<int>(PublisherState::kFailing) == status_t::PUBLISHER_FAILING);

using wire_values::FromMicroseconds;
using wire_values::IsText;
using wire_values::Microseconds;
using wire_values::ReadEnum;
using wire_values::Signed;
using wire_values::Unsigned;
using wire_values::WireEnum;

void WritePose(const MarkerPose& marker, marker_pose_t& wire) {
  wire.pose_valid = marker.has_pose;
  if (marker.has_pose) {
    wire_values::WriteVector(marker.camera_from_marker.translation, wire.position);
    wire_values::WriteRotation(marker.camera_from_marker.rotation, wire.orientation);
    wire_values::WriteTriangle(marker.covariance, wire.covariance);
    wire.ambiguity = static_cast<float>(marker.ambiguity);
    return;
  }
  std::fill(std::begin(wire.position), std::end(wire.position), wire_values::kNaN);
  std::fill(std::begin(wire.orientation), std::end(wire.orientation), wire_values::kNaN);
  std::fill(std::begin(wire.covariance), std::end(wire.covariance), static_cast<float>(wire_values::kNaN));
  wire.ambiguity = static_cast<float>(wire_values::kNaN);
}

void WriteMarker(const MarkerPose& marker, marker_pose_t& wire) {
  wire.id = Signed(marker.id.value_or(0));
  wire.id_valid = marker.id.has_value();
  wire.variant = WireEnum(marker.variant);
  wire.rows = static_cast<std::int8_t>(marker.size.rows);
  wire.cols = static_cast<std::int8_t>(marker.size.cols);
  wire.family = static_cast<std::int16_t>(marker.family);
  WritePose(marker, wire);
  for (int i = 0; i < 2; ++i) wire.center_px[i] = static_cast<float>(marker.center_px(i));
  wire.corners_used = static_cast<std::int16_t>(marker.corners_used);
  wire.bits_corrected = static_cast<std::int16_t>(marker.id ? marker.bits_corrected : 0);
  wire.reprojection_rms_px = static_cast<float>(marker.reprojection_rms_px);
  wire.luminance_overlap = static_cast<float>(marker.luminance_overlap);
  wire.saturation_overlap = static_cast<float>(marker.saturation_overlap);
  wire.warnings = static_cast<std::int32_t>(marker.warnings);
}

void Write(const PosesMessage& message, poses_t& wire) {
  wire_values::WriteHeader(message, wire);
  wire.frames_dropped = Signed(message.frames_dropped);
  wire.image_width = message.image_width;
  wire.image_height = message.image_height;
  wire.marker_count = static_cast<std::int32_t>(message.markers.size());
  wire.markers.resize(message.markers.size());
  for (std::size_t i = 0; i < message.markers.size(); ++i) WriteMarker(message.markers[i], wire.markers[i]);
}

void WriteCounts(const std::vector<NamedCount>& counts, std::int32_t& wire_count, std::vector<count_t>& wire) {
  wire_count = static_cast<std::int32_t>(counts.size());
  wire.resize(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    wire[i].name = counts[i].name;
    wire[i].count = Signed(counts[i].count);
  }
}

void WriteStages(const std::vector<StageLatency>& stages, status_t& wire) {
  wire.stage_count = static_cast<std::int32_t>(stages.size());
  wire.stages.resize(stages.size());
  for (std::size_t i = 0; i < stages.size(); ++i) {
    wire.stages[i].stage = stages[i].stage;
    wire.stages[i].frames = Signed(stages[i].frames);
    wire.stages[i].median_us = stages[i].median.count();
    wire.stages[i].p99_us = stages[i].p99.count();
    wire.stages[i].worst_us = stages[i].worst.count();
  }
}

void Write(const StatusMessage& message, status_t& wire) {
  wire.utc_us = Microseconds(message.utc);
  wire.monotonic_us = Microseconds(message.monotonic);
  wire.uptime_us = message.uptime.count();
  wire.version = message.version;
  wire.camera = message.camera;
  wire.camera_state = WireEnum(message.camera_state);
  wire.camera_source = message.camera_source;
  wire.camera_message = message.camera_message;
  wire.publisher_state = WireEnum(message.publisher.state);
  wire.publisher_message = message.publisher.message;
  wire.messages_sent = Signed(message.publisher.sent);
  wire.messages_failed = Signed(message.publisher.failed);
  wire.window_us = message.window.count();
  wire.capture_rate_hz = message.capture_rate_hz;
  wire.publish_rate_hz = message.publish_rate_hz;
  wire.frames_captured = Signed(message.frames_captured);
  wire.frames_published = Signed(message.frames_published);
  wire.frames_dropped = Signed(message.frames_dropped);
  wire.queue_depth = message.queue_depth;
  wire.queue_capacity = message.queue_capacity;
  wire.worker_count = message.workers;
  wire.markers_mean = message.markers_mean;
  wire.markers_min = message.markers_min;
  wire.markers_max = message.markers_max;
  WriteCounts(message.drops, wire.drop_count, wire.drops);
  WriteStages(message.stages, wire);
  WriteCounts(message.detections, wire.detection_count, wire.detections);
}

void ReadPose(const marker_pose_t& wire, MarkerPose& marker) {
  marker.has_pose = true;
  marker.camera_from_marker = {wire_values::ReadRotation(wire.orientation), wire_values::ReadVector(wire.position)};
  wire_values::ReadTriangle(wire.covariance, marker.covariance);
  marker.ambiguity = static_cast<double>(wire.ambiguity);
}

bool ReadMarker(const marker_pose_t& wire, MarkerPose& marker) {
  marker.size = {wire.rows, wire.cols};
  if (!IsValid(marker.size) || wire.family < 0) return false;
  marker.variant = ReadEnum<Variant>(wire.variant);
  if (wire.id_valid != 0) marker.id = Unsigned(wire.id);
  marker.family = wire.family;
  if (wire.pose_valid != 0) ReadPose(wire, marker);
  marker.corners.fill(Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
  marker.center_px = {static_cast<double>(wire.center_px[0]), static_cast<double>(wire.center_px[1])};
  marker.corners_used = wire.corners_used;
  marker.bits_corrected = wire.bits_corrected;
  marker.reprojection_rms_px = static_cast<double>(wire.reprojection_rms_px);
  marker.luminance_overlap = static_cast<double>(wire.luminance_overlap);
  marker.saturation_overlap = static_cast<double>(wire.saturation_overlap);
  marker.warnings = static_cast<std::uint32_t>(wire.warnings);
  return true;
}

bool AreTexts(const std::vector<count_t>& counts) {
  return std::all_of(counts.begin(), counts.end(), [](const count_t& count) { return IsText(count.name); });
}

bool AreTexts(const std::vector<stage_latency_t>& stages) {
  return std::all_of(stages.begin(), stages.end(), [](const stage_latency_t& stage) { return IsText(stage.stage); });
}

bool HoldsTexts(const status_t& wire) {
  return IsText(wire.version) && IsText(wire.camera) && IsText(wire.camera_source) && IsText(wire.camera_message) &&
         IsText(wire.publisher_message) && AreTexts(wire.drops) && AreTexts(wire.stages) && AreTexts(wire.detections);
}

std::optional<ReceivedMessage> Read(const poses_t& wire) {
  PosesMessage message;
  if (!wire_values::ReadHeader(wire, message)) return std::nullopt;
  message.frames_dropped = Unsigned(wire.frames_dropped);
  message.image_width = wire.image_width;
  message.image_height = wire.image_height;
  message.markers.resize(wire.markers.size());
  for (std::size_t i = 0; i < wire.markers.size(); ++i)
    if (!ReadMarker(wire.markers[i], message.markers[i])) return std::nullopt;
  return message;
}

std::vector<NamedCount> ReadCounts(const std::vector<count_t>& wire) {
  std::vector<NamedCount> counts;
  for (const count_t& count : wire) counts.push_back({count.name, Unsigned(count.count)});
  return counts;
}

std::optional<ReceivedMessage> Read(const status_t& wire) {
  if (!HoldsTexts(wire)) return std::nullopt;
  StatusMessage message;
  message.utc = FromMicroseconds<UtcTime>(wire.utc_us);
  message.monotonic = FromMicroseconds<MonotonicTime>(wire.monotonic_us);
  message.uptime = std::chrono::microseconds(wire.uptime_us);
  message.version = wire.version;
  message.camera = wire.camera;
  message.camera_state = ReadEnum<CameraState>(wire.camera_state);
  message.camera_source = wire.camera_source;
  message.camera_message = wire.camera_message;
  message.publisher = {ReadEnum<PublisherState>(wire.publisher_state), wire.publisher_message,
                       Unsigned(wire.messages_sent), Unsigned(wire.messages_failed)};
  message.window = std::chrono::microseconds(wire.window_us);
  message.capture_rate_hz = wire.capture_rate_hz;
  message.publish_rate_hz = wire.publish_rate_hz;
  message.frames_captured = Unsigned(wire.frames_captured);
  message.frames_published = Unsigned(wire.frames_published);
  message.frames_dropped = Unsigned(wire.frames_dropped);
  message.queue_depth = wire.queue_depth;
  message.queue_capacity = wire.queue_capacity;
  message.workers = wire.worker_count;
  message.markers_mean = wire.markers_mean;
  message.markers_min = wire.markers_min;
  message.markers_max = wire.markers_max;
  message.drops = ReadCounts(wire.drops);
  for (const stage_latency_t& stage : wire.stages)
    message.stages.push_back({stage.stage, Unsigned(stage.frames), std::chrono::microseconds(stage.median_us),
                              std::chrono::microseconds(stage.p99_us), std::chrono::microseconds(stage.worst_us)});
  message.detections = ReadCounts(wire.detections);
  return message;
}

template <typename Wire>
std::span<const std::uint8_t> EncodeInto(const Wire& wire, std::vector<std::uint8_t>& bytes) {
  bytes.resize(static_cast<std::size_t>(wire.getEncodedSize()));
  const int written = wire.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  CHEQUER_CHECK(written == static_cast<int>(bytes.size()), "an LCM type was not encoded into the size it asked for");
  return bytes;
}

template <typename Wire>
std::optional<ReceivedMessage> DecodeAs(std::span<const std::uint8_t> bytes) {
  Wire wire;
  if (wire.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return std::nullopt;
  return Read(wire);
}

}  // namespace

struct WireEncoder::Scratch {
  poses_t poses;
  status_t status;
  robots_t robots;
  tracks_t tracks;
  std::vector<std::uint8_t> bytes;
};

WireEncoder::WireEncoder() : scratch_(std::make_unique<Scratch>()) {}
WireEncoder::~WireEncoder() = default;
WireEncoder::WireEncoder(WireEncoder&&) noexcept = default;
WireEncoder& WireEncoder::operator=(WireEncoder&&) noexcept = default;

std::span<const std::uint8_t> WireEncoder::Encode(const PosesMessage& message) {
  Write(message, scratch_->poses);
  return EncodeInto(scratch_->poses, scratch_->bytes);
}

std::span<const std::uint8_t> WireEncoder::Encode(const StatusMessage& message) {
  Write(message, scratch_->status);
  return EncodeInto(scratch_->status, scratch_->bytes);
}

std::span<const std::uint8_t> WireEncoder::Encode(const RobotsMessage& message) {
  Write(message, scratch_->robots);
  return EncodeInto(scratch_->robots, scratch_->bytes);
}

std::span<const std::uint8_t> WireEncoder::Encode(const TracksMessage& message) {
  Write(message, scratch_->tracks);
  return EncodeInto(scratch_->tracks, scratch_->bytes);
}

std::optional<ReceivedMessage> DecodeMessage(std::span<const std::uint8_t> bytes) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return std::nullopt;
  try {
    if (auto poses = DecodeAs<poses_t>(bytes)) return poses;
    if (auto tracks = DecodeAs<tracks_t>(bytes)) return tracks;
    if (auto robots = DecodeAs<robots_t>(bytes)) return robots;
    return DecodeAs<status_t>(bytes);
  } catch (const std::exception&) {
    return std::nullopt;  // a count of elements that is negative or more than memory holds
  }
}

}  // namespace chequer
