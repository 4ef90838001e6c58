#include "view/page_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "view/page_time.h"

namespace chequer {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kJsonHeaderBytes = 8;

SharedPacket JsonPacket(TopicKind kind, std::uint16_t index, const Json& json) {
  // Texts come from the network: any bytes.
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  auto packet = std::make_shared<Packet>();
  std::vector<std::uint8_t>& bytes = packet->storage();
  bytes.reserve(Packet::kHeadroom + kJsonHeaderBytes + text.size());
  bytes.resize(Packet::kHeadroom + kJsonHeaderBytes);
  packet->data()[0] = static_cast<std::uint8_t>(kind);
  packet->data()[2] = static_cast<std::uint8_t>(index);
  packet->data()[3] = static_cast<std::uint8_t>(index >> 8);
  bytes.insert(bytes.end(), text.begin(), text.end());
  return packet;
}

double Ms(std::chrono::microseconds time) { return static_cast<double>(time.count()) / 1000; }

Json CountsJson(const std::vector<NamedCount>& counts) {
  Json json = Json::object();
  for (const NamedCount& count : counts) json[count.name] = count.count;
  return json;
}

Json Numbers(const auto& vector) {
  Json json = Json::array();
  for (int i = 0; i < static_cast<int>(vector.size()); ++i) json.push_back(vector[i]);
  return json;
}

Json RotationJson(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

/// JSON has no NaN: null stands for it.
Json NumberOrNull(float value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json Judgement(std::optional<bool> judged) { return judged ? Json(*judged) : Json(nullptr); }

Json CellJson(const DetailCell& cell) {
  Json outline = Json::array();
  for (const Eigen::Vector2f& corner : cell.outline_px)
    for (int axis = 0; axis < 2; ++axis) outline.push_back(NumberOrNull(corner(axis)));
  return {{"outline", std::move(outline)},
          {"luminance", NumberOrNull(cell.luminance)},
          {"saturation", NumberOrNull(cell.saturation)},
          {"saturated", Judgement(cell.saturated)},
          {"expected", Judgement(cell.expected)},
          {"seen", cell.seen},
          {"log_likelihood", NumberOrNull(cell.log_likelihood)}};
}

Json SummaryJson(const NormalSummary& summary) { return {{"mean", summary.mean}, {"deviation", summary.deviation}}; }

std::string IdText(std::optional<std::uint64_t> id) { return id ? std::to_string(*id) : std::string(); }

}  // namespace

SharedPacket StatusPacket(const StatusMessage& status, std::uint16_t index) {
  static constexpr const char* kCameraStates[] = {"waiting", "running", "ended"};
  static constexpr const char* kPublisherStates[] = {"waiting", "ready", "failing"};
  const auto camera_state = static_cast<std::size_t>(status.camera_state);
  const auto publisher_state = static_cast<std::size_t>(status.publisher.state);
  Json stages = Json::array();
  for (const StageLatency& stage : status.stages)
    stages.push_back({{"stage", stage.stage},
                      {"frames", stage.frames},
                      {"median_ms", Ms(stage.median)},
                      {"p99_ms", Ms(stage.p99)},
                      {"worst_ms", Ms(stage.worst)}});
  return JsonPacket(TopicKind::kStatus, index,
                    {{"utc_ms", Milliseconds(status.utc)},
                     {"uptime_s", std::chrono::duration<double>(status.uptime).count()},
                     {"version", status.version},
                     {"camera", status.camera},
                     {"camera_state", camera_state < 3 ? kCameraStates[camera_state] : "unknown"},
                     {"camera_source", status.camera_source},
                     {"camera_message", status.camera_message},
                     {"publisher_state", publisher_state < 3 ? kPublisherStates[publisher_state] : "unknown"},
                     {"publisher_message", status.publisher.message},
                     {"messages_sent", status.publisher.sent},
                     {"messages_failed", status.publisher.failed},
                     {"capture_rate_hz", status.capture_rate_hz},
                     {"publish_rate_hz", status.publish_rate_hz},
                     {"frames_captured", status.frames_captured},
                     {"frames_published", status.frames_published},
                     {"frames_dropped", status.frames_dropped},
                     {"queue_depth", status.queue_depth},
                     {"workers", status.workers},
                     {"markers_mean", status.markers_mean},
                     {"markers_min", status.markers_min},
                     {"markers_max", status.markers_max},
                     {"drops", CountsJson(status.drops)},
                     {"stages", std::move(stages)},
                     {"detections", CountsJson(status.detections)}});
}

SharedPacket CameraPacket(const CameraMessage& camera, std::uint16_t index) {
  Json json = {{"utc_ms", Milliseconds(camera.utc)}, {"camera", camera.camera}};
  if (camera.model) {
    static constexpr const char* kKinds[] = {"pinhole", "brown_conrady", "fisheye"};
    const CameraModel& model = *camera.model;
    json["model"] = {{"kind", kKinds[static_cast<std::size_t>(model.kind)]},
                     {"width", model.width},
                     {"height", model.height},
                     {"fx", model.fx},
                     {"fy", model.fy},
                     {"cx", model.cx},
                     {"cy", model.cy},
                     {"distortion", model.distortion}};
    // Where the frame's rim is seen, on the plane z = 1: for drawing the field of view.
    Json rim = Json::array();
    constexpr int kSteps = 8;
    const double right = model.width - 0.5, bottom = model.height - 0.5;
    for (int side = 0; side < 4; ++side)
      for (int i = 0; i < kSteps; ++i) {
        const double t = static_cast<double>(i) / kSteps;
        const Eigen::Vector2d corners[] = {{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}};
        const auto at = model.Undistort(corners[side] + t * (corners[(side + 1) % 4] - corners[side]));
        if (at) rim.push_back({at->x(), at->y()});
      }
    json["rim"] = std::move(rim);
  }
  if (camera.world_from_camera)
    json["world_from_camera"] = {{"position", Numbers(camera.world_from_camera->translation)},
                                 {"orientation", RotationJson(camera.world_from_camera->rotation)}};
  json["families"] = Json::array();
  for (const CameraMessage::Family& family : camera.families)
    json["families"].push_back({{"variant", VariantName(family.variant)},
                                {"rows", family.size.rows},
                                {"cols", family.size.cols},
                                {"side_m", family.side_m}});
  return JsonPacket(TopicKind::kCamera, index, json);
}

SharedPacket DetailPacket(const DetailMessage& detail, std::uint16_t index) {
  Json corners = Json::array(), cells = Json::array();
  for (const Eigen::Vector2f& corner : detail.corners)
    corners.push_back(corner.allFinite() ? Json{corner.x(), corner.y()} : Json(nullptr));
  for (const DetailCell& cell : detail.cells) cells.push_back(CellJson(cell));
  return JsonPacket(TopicKind::kDetail, index,
                    {{"captured_ms", Milliseconds(detail.captured_utc)},
                     {"sequence", detail.sequence},
                     {"found", detail.found},
                     {"message", detail.message},
                     {"family", detail.family},
                     {"id", detail.id ? Json(IdText(detail.id)) : Json(nullptr)},
                     {"variant", VariantName(detail.variant)},
                     {"rows", detail.size.rows},
                     {"cols", detail.size.cols},
                     {"center", Numbers(detail.center_px)},
                     {"bits_corrected", detail.bits_corrected},
                     {"reprojection_rms_px", detail.reprojection_rms_px},
                     {"warnings", detail.warnings},
                     {"corners", std::move(corners)},
                     {"cells", std::move(cells)},
                     {"luminance_dark", SummaryJson(detail.luminance_dark)},
                     {"luminance_light", SummaryJson(detail.luminance_light)},
                     {"luminance_overlap", detail.luminance_overlap},
                     {"saturation_plain", SummaryJson(detail.saturation_plain)},
                     {"saturation_saturated", SummaryJson(detail.saturation_saturated)},
                     {"saturation_overlap", detail.saturation_overlap}});
}

SharedPacket CalibrationPacket(const CalibrationMessage& message, std::uint16_t index) {
  static constexpr const char* kKinds[] = {"lens", "world"};
  static constexpr const char* kStates[] = {"collecting", "solving", "done", "failed"};
  const auto kind = static_cast<std::size_t>(message.kind), state = static_cast<std::size_t>(message.state);
  Json residuals = Json::array(), references = Json::array();
  for (const CalibrationMessage::Residual& each : message.residuals)
    for (const Eigen::Vector2f& point : {each.pixel, each.error_px})
      for (int axis = 0; axis < 2; ++axis) residuals.push_back(point(axis));
  for (const CalibrationMessage::Reference& each : message.references)
    references.push_back({{"id", IdText(each.id)},
                          {"frames", each.frames},
                          {"center", Numbers(each.center_px)},
                          {"offset_m", each.offset_m ? Numbers(*each.offset_m) : Json(nullptr)},
                          {"limit_m", each.limit_m}});
  return JsonPacket(TopicKind::kCalibration, index,
                    {{"utc_ms", Milliseconds(message.utc)},
                     {"kind", kind < 2 ? kKinds[kind] : "unknown"},
                     {"state", state < 4 ? kStates[state] : "unknown"},
                     {"advice", message.advice},
                     {"width", message.width},
                     {"height", message.height},
                     {"frames", message.frames},
                     {"views", message.views},
                     {"tilted", message.tilted},
                     {"edge_px", message.edge_px},
                     {"rows", message.rows},
                     {"cols", message.cols},
                     {"parts", message.parts},
                     {"rms", message.rms},
                     {"residuals", std::move(residuals)},
                     {"references", std::move(references)}});
}

HistoryEntry EntryOf(const StatusMessage& status, std::uint64_t dropped_before) {
  HistoryEntry entry{.utc = status.utc,
                     .capture_rate_hz = status.capture_rate_hz,
                     .publish_rate_hz = status.publish_rate_hz,
                     .markers_mean = status.markers_mean,
                     .dropped = status.frames_dropped - std::min(status.frames_dropped, dropped_before),
                     .camera_state = status.camera_state};
  for (const StageLatency& stage : status.stages)
    if (stage.stage == "total" && stage.frames > 0) {
      entry.median_ms = Ms(stage.median);
      entry.p99_ms = Ms(stage.p99);
    }
  for (const NamedCount& count : status.detections)
    if (count.name == "deferred") entry.deferred = count.count;
  return entry;
}

SharedPacket HistoryPacket(const std::deque<HistoryEntry>& entries, std::uint16_t index) {
  Json rows = Json::array();
  for (const HistoryEntry& entry : entries)
    rows.push_back({Milliseconds(entry.utc), entry.capture_rate_hz, entry.publish_rate_hz, entry.markers_mean,
                    entry.median_ms, entry.p99_ms, entry.dropped, entry.deferred,
                    static_cast<int>(entry.camera_state)});
  return JsonPacket(TopicKind::kHistory, index, {{"rows", std::move(rows)}});
}

SharedPacket ServerPacket(const ServerState& state) {
  Json cameras = Json::array();
  for (const ServerState::Camera& camera : state.cameras)
    cameras.push_back({{"prefix", camera.prefix}, {"name", camera.name}});
  Json json = {{"instance", state.instance}, {"version", state.version},       {"url", state.lcm_url},
               {"trouble", state.trouble},   {"unreadable", state.unreadable}, {"cameras", std::move(cameras)}};
  if (state.replay)
    json["replay"] = {{"log", state.replay->log},
                      {"first_ms", Milliseconds(state.replay->first)},
                      {"last_ms", Milliseconds(state.replay->last)},
                      {"now_ms", Milliseconds(state.replay->now)},
                      {"speed", state.replay->speed},
                      {"playing", state.replay->playing}};
  return JsonPacket(TopicKind::kServer, 0, json);
}

}  // namespace chequer
