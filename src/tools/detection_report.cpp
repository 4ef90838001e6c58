#include "tools/detection_report.h"

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tools/columns.h"
#include "tools/marker_json.h"

namespace chequer {
namespace {

Json Corners(const MarkerPose& marker) {
  Json corners = Json::array();
  for (int i = 0; i < CornerCount(marker.size); ++i) {
    const Eigen::Vector2f& corner = marker.corners[static_cast<std::size_t>(i)];
    corners.push_back(corner.allFinite() ? Json::array({corner.x(), corner.y()}) : Json());
  }
  return corners;
}

Json Marker(const MarkerPose& marker) {
  Json json;
  json["id"] = marker.id ? Json(*marker.id) : Json();
  json["variant"] = VariantName(marker.variant);
  AddPose(marker, json);
  json["corners"] = Corners(marker);
  AddQuality(marker, json);
  return json;
}

/// Position in metres where there is one, else the centre in pixels.
std::string Place(const MarkerPose& marker) {
  if (!marker.has_pose) return fmt::format("({:.2f}, {:.2f}) px", marker.center_px.x(), marker.center_px.y());
  const Eigen::Vector3d& position = marker.camera_from_marker.translation;
  return fmt::format("({:.4f}, {:.4f}, {:.4f}) m", position.x(), position.y(), position.z());
}

}  // namespace

std::string JsonLine(const ImageReport& report) {
  Json json;
  json["file"] = report.file;
  json["width"] = report.width;
  json["height"] = report.height;
  json["detect_ms"] = report.detect_ms;
  json["work"] = report.work;
  json["markers"] = Json::array();
  for (const MarkerPose& marker : report.markers) json["markers"].push_back(Marker(marker));
  return Dump(std::move(json));
}

std::string Table(const ImageReport& report) {
  std::string text = fmt::format("{}: {}x{}, {} marker{}, {:.2f} ms\n", report.file, report.width, report.height,
                                 report.markers.size(), report.markers.size() == 1 ? "" : "s", report.detect_ms);
  if (report.markers.empty()) return text;
  std::vector<std::vector<std::string>> rows{{"  id", "variant", "position", "corners", "rms px", "warnings"}};
  for (const MarkerPose& marker : report.markers)
    rows.push_back({marker.id ? std::to_string(*marker.id) : "-", std::string(VariantName(marker.variant)),
                    Place(marker), fmt::format("{}/{}", marker.corners_used, CornerCount(marker.size)),
                    fmt::format("{:.3f}", marker.reprojection_rms_px), WarningNames(marker, ", ")});
  return text + Columns(rows, "><<>><");
}

}  // namespace chequer
