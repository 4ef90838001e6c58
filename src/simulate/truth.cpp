#include "simulate/truth.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "core/file.h"
#include "core/output_file.h"

namespace chequer {
namespace {

// In the order in which they were put in: the file is read by people too.
using Json = nlohmann::ordered_json;

bool WithinFrame(const SceneMarker& marker, const CameraModel& camera) {
  for (int row = 0; row <= marker.board.rows; ++row)
    for (int col = 0; col <= marker.board.cols; ++col) {
      const Eigen::Vector2d pixel = camera.Project(marker.camera_from_marker * marker.PointAt(col, row));
      if (pixel.x() < -0.5 || pixel.y() < -0.5 || pixel.x() > camera.width - 0.5 || pixel.y() > camera.height - 0.5)
        return false;
    }
  return true;
}

Json ToJson(const TrueMarker& marker, bool of_stream) {
  const Eigen::Vector3d& t = marker.camera_from_marker.translation;
  const Eigen::Quaterniond q = Canonical(marker.camera_from_marker.rotation);
  Json json{{"id", marker.id},
            {"variant", marker.variant},
            {"size", ToString(marker.size)},
            {"side", marker.side_m},
            {"position", {t.x(), t.y(), t.z()}},
            {"orientation", {q.w(), q.x(), q.y(), q.z()}},
            {"center_px", {marker.center_px.x(), marker.center_px.y()}},
            {"cell_px", marker.cell_px}};
  if (!of_stream) return json;
  json["inside"] = marker.inside;
  json["visible"] = marker.visible;
  json["motion_px"] = marker.motion_px;
  return json;
}

MarkerSize SizeFromText(const std::string& text) {
  // Not ParseMarkerSize alone: the peers' patterns may have sizes that colour checkerboards cannot have.
  if (const auto size = ParseMarkerSize(text)) return *size;
  const std::size_t times = text.find('x');
  if (times == std::string::npos)
    throw std::runtime_error("size must be ROWSxCOLS, such as \"6x6\", not \"" + text + "\"");
  return {std::stoi(text.substr(0, times)), std::stoi(text.substr(times + 1))};
}

TrueMarker MarkerFromJson(const Json& json) {
  TrueMarker marker;
  marker.id = json.at("id").get<std::uint64_t>();
  marker.variant = json.at("variant").get<std::string>();
  marker.size = SizeFromText(json.at("size").get<std::string>());
  marker.side_m = json.at("side").get<double>();
  const auto t = json.at("position").get<std::array<double, 3>>();
  const auto q = json.at("orientation").get<std::array<double, 4>>();
  marker.camera_from_marker.translation = {t[0], t[1], t[2]};
  marker.camera_from_marker.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  const auto center = json.at("center_px").get<std::array<double, 2>>();
  marker.center_px = {center[0], center[1]};
  marker.cell_px = json.at("cell_px").get<double>();
  marker.inside = json.value("inside", marker.inside);
  marker.visible = json.value("visible", marker.visible);
  marker.motion_px = json.value("motion_px", marker.motion_px);
  return marker;
}

FrameTruth FrameFromLine(const std::string& line) {
  const Json json = Json::parse(line);
  FrameTruth frame;
  frame.file = json.at("file").get<std::string>();
  frame.phase = json.value("phase", frame.phase);
  if (json.contains("time_s")) frame.time_s = json["time_s"].get<double>();
  for (const Json& marker : json.at("markers")) frame.markers.push_back(MarkerFromJson(marker));
  return frame;
}

}  // namespace

TrueMarker Describe(const SceneMarker& marker, const CameraModel& camera) {
  const int rim = 2 * marker.board.uncounted_rim;
  return {.id = marker.board.id,
          .variant = marker.board.variant,
          .size = {marker.board.rows - rim, marker.board.cols - rim},
          .side_m = marker.side_m,
          .camera_from_marker = marker.camera_from_marker,
          .center_px = CenterPx(marker, camera),
          .cell_px = SmallestCellPx(marker, camera)};
}

std::vector<TrueMarker> TruthOf(const std::vector<SceneMarker>& markers, const CameraModel& camera) {
  std::vector<TrueMarker> truth;
  for (const SceneMarker& marker : markers) {
    if (!IsDrawable(marker, camera) || !WithinFrame(marker, camera)) continue;
    truth.push_back(Describe(marker, camera));
  }
  return truth;
}

std::string ToJsonLine(const FrameTruth& truth) {
  const bool of_stream = truth.time_s.has_value();
  Json json{{"file", truth.file}};
  if (of_stream) json["phase"] = truth.phase;
  if (of_stream) json["time_s"] = *truth.time_s;
  Json& markers = json["markers"] = Json::array();
  for (const TrueMarker& marker : truth.markers) markers.push_back(ToJson(marker, of_stream));
  return json.dump();
}

void WriteTruth(const std::filesystem::path& path, const std::vector<FrameTruth>& frames) {
  OutputFile file(path);
  for (const FrameTruth& frame : frames) file.Write(ToJsonLine(frame) + "\n");
  file.Finish();
}

std::vector<FrameTruth> ReadTruth(const std::filesystem::path& path) {
  std::istringstream file(ReadFile(path, kMaxTextBytes));
  std::vector<FrameTruth> frames;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      frames.push_back(FrameFromLine(line));
    } catch (const std::exception& error) {
      throw std::runtime_error(path.string() + ", line " + std::to_string(number) + ": " + error.what());
    }
  }
  return frames;
}

}  // namespace chequer
