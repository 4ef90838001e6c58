#include "tools/message_text.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/printable.h"
#include "tools/marker_json.h"
#include "tools/message_json.h"

namespace chequer {
namespace {

constexpr std::array kInstants{"unknown", "start", "middle", "end"};
constexpr std::array kCameraStates{"waiting", "running", "ended"};
constexpr std::array kPublisherStates{"waiting", "ready", "failing"};

template <typename Enum, typename Names>
const char* Name(Enum value, const Names& names) {
  const auto index = static_cast<std::size_t>(value);
  return index < names.size() ? names[index] : "unknown";  // of a newer version
}

Json MarkerJson(const MarkerPose& marker) {
  Json json;
  json["id"] = marker.id ? Json(*marker.id) : Json();
  json["variant"] = VariantName(marker.variant);
  json["size"] = ToString(marker.size);
  json["family"] = marker.family;
  AddPose(marker, json);
  json["center_px"] = {marker.center_px.x(), marker.center_px.y()};
  AddQuality(marker, json);
  return json;
}

Json CountsJson(const std::vector<NamedCount>& counts) {
  Json json = Json::object();
  for (const NamedCount& count : counts) json[count.name] = count.count;
  return json;
}

Json StagesJson(const std::vector<StageLatency>& stages) {
  Json json = Json::object();
  for (const StageLatency& stage : stages)
    json[stage.stage] = {{"frames", stage.frames},
                         {"median_us", stage.median.count()},
                         {"p99_us", stage.p99.count()},
                         {"worst_us", stage.worst.count()}};
  return json;
}

std::string MarkerText(const MarkerPose& marker) {
  const std::string id = marker.id ? std::to_string(*marker.id) : "?";
  if (!marker.has_pose)
    return fmt::format("{} ({}, {}) px", id, FixedText(marker.center_px.x(), 1), FixedText(marker.center_px.y(), 1));
  const Eigen::Vector3d& position = marker.camera_from_marker.translation;
  return fmt::format("{} ({}, {}, {}) m {} deg", id, FixedText(position.x(), 3), FixedText(position.y(), 3),
                     FixedText(position.z(), 3), FixedText(HeadingDegrees(marker), 1));
}

std::string CsvPose(const MarkerPose& marker) {
  if (!marker.has_pose) return ",,,,,,,";
  const Eigen::Vector3d& t = marker.camera_from_marker.translation;
  const Eigen::Quaterniond q = Canonical(marker.camera_from_marker.rotation);
  return fmt::format("{},{},{},{},{},{},{},{}", PlainZero(t.x()), PlainZero(t.y()), PlainZero(t.z()), PlainZero(q.w()),
                     PlainZero(q.x()), PlainZero(q.y()), PlainZero(q.z()), FixedText(HeadingDegrees(marker), 3));
}

}  // namespace

std::string CsvField(const std::string& text) {
  // Names come from other programs and may hold what separates fields, and what a terminal obeys.
  const std::string clean = Printable(text);
  if (clean.find_first_of(",\"") == std::string::npos) return clean;
  std::string quoted = "\"";
  for (const char c : clean) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + "\"";
}

std::string FixedText(double number, int digits) {
  std::string text = fmt::format("{:.{}f}", number, digits);
  if (text.front() == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

double HeadingDegrees(const MarkerPose& marker) {
  const Eigen::Vector3d x_axis = marker.camera_from_marker.rotation * Eigen::Vector3d::UnitX();
  return std::atan2(x_axis.y(), x_axis.x()) * 180 / std::numbers::pi;
}

std::string JsonLine(const std::string& channel, const PosesMessage& message) {
  Json json;
  json["type"] = "poses";
  json["channel"] = channel;
  json["camera"] = message.camera;
  json["frame"] = message.frame;
  json["sequence"] = message.sequence;
  json["captured_utc_us"] = Microseconds(message.captured_utc);
  json["captured_monotonic_us"] = Microseconds(message.captured_monotonic);
  json["instant"] = Name(message.instant, kInstants);
  json["published_utc_us"] = Microseconds(message.published_utc);
  json["published_monotonic_us"] = Microseconds(message.published_monotonic);
  json["frames_dropped"] = message.frames_dropped;
  json["width"] = message.image_width;
  json["height"] = message.image_height;
  json["markers"] = Json::array();
  for (const MarkerPose& marker : message.markers) json["markers"].push_back(MarkerJson(marker));
  return Dump(std::move(json));
}

std::string JsonLine(const std::string& channel, const StatusMessage& message) {
  Json json;
  json["type"] = "status";
  json["channel"] = channel;
  json["utc_us"] = Microseconds(message.utc);
  json["monotonic_us"] = Microseconds(message.monotonic);
  json["uptime_us"] = message.uptime.count();
  json["version"] = message.version;
  json["camera"] = message.camera;
  json["camera_state"] = Name(message.camera_state, kCameraStates);
  json["camera_source"] = message.camera_source;
  json["camera_message"] = message.camera_message;
  json["publisher_state"] = Name(message.publisher.state, kPublisherStates);
  json["publisher_message"] = message.publisher.message;
  json["messages_sent"] = message.publisher.sent;
  json["messages_failed"] = message.publisher.failed;
  json["window_us"] = message.window.count();
  json["capture_rate_hz"] = message.capture_rate_hz;
  json["publish_rate_hz"] = message.publish_rate_hz;
  json["frames_captured"] = message.frames_captured;
  json["frames_published"] = message.frames_published;
  json["frames_dropped"] = message.frames_dropped;
  json["queue_depth"] = message.queue_depth;
  json["queue_capacity"] = message.queue_capacity;
  json["worker_count"] = message.workers;
  json["markers_mean"] = message.markers_mean;
  json["markers_min"] = message.markers_min;
  json["markers_max"] = message.markers_max;
  json["drops"] = CountsJson(message.drops);
  json["stages"] = StagesJson(message.stages);
  json["detections"] = CountsJson(message.detections);
  return Dump(std::move(json));
}

std::string PlainLine(const PosesMessage& message) {
  std::string text = fmt::format("{} frame {}: {} marker{}", Printable(message.camera), message.sequence,
                                 message.markers.size(), message.markers.size() == 1 ? "" : "s");
  for (const MarkerPose& marker : message.markers) text.append("  ").append(MarkerText(marker));
  return text;
}

std::string PlainLine(const StatusMessage& message) {
  std::string text = fmt::format("{} status: camera {}, {:.1f} frames/s, {:.1f} markers a frame, {} frames dropped",
                                 Printable(message.camera), Name(message.camera_state, kCameraStates),
                                 message.publish_rate_hz, message.markers_mean, message.frames_dropped);
  for (const StageLatency& stage : message.stages)
    if (stage.stage == "total" && stage.frames > 0)
      text += fmt::format(", latency {:.1f} ms (worst {:.1f})", static_cast<double>(stage.median.count()) / 1000,
                          static_cast<double>(stage.worst.count()) / 1000);
  for (const std::string& trouble : {message.camera_message, message.publisher.message})
    if (!trouble.empty()) text.append("; ").append(Printable(trouble));
  return text;
}

std::string CsvHeader() {
  return "channel,camera,sequence,captured_utc_us,captured_monotonic_us,published_utc_us,id,variant,size,x_m,y_m,z_m,"
         "qw,qx,qy,qz,heading_deg,center_x_px,center_y_px,corners_used,reprojection_rms_px,ambiguity,"
         "luminance_overlap,saturation_overlap,bits_corrected,warnings\n";
}

std::string CsvRows(const std::string& channel, const PosesMessage& message) {
  const std::string frame = fmt::format("{},{},{},{},{},{}", CsvField(channel), CsvField(message.camera),
                                        message.sequence, Microseconds(message.captured_utc),
                                        Microseconds(message.captured_monotonic), Microseconds(message.published_utc));
  if (message.markers.empty()) return frame + std::string(20, ',') + "\n";
  std::string rows;
  for (const MarkerPose& marker : message.markers)
    rows += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", frame, marker.id ? std::to_string(*marker.id) : "",
        VariantName(marker.variant), ToString(marker.size), CsvPose(marker), marker.center_px.x(), marker.center_px.y(),
        marker.corners_used, marker.reprojection_rms_px, marker.has_pose ? fmt::format("{}", marker.ambiguity) : "",
        marker.luminance_overlap, marker.saturation_overlap, marker.bits_corrected, WarningNames(marker, " "));
  return rows;
}

}  // namespace chequer
