#include "tools/marker_json.h"

namespace chequer {

void AddPose(const MarkerPose& marker, Json& json) {
  if (!marker.has_pose) return;
  const Eigen::Vector3d& position = marker.camera_from_marker.translation;
  const Eigen::Quaterniond rotation = Canonical(marker.camera_from_marker.rotation);
  json["position"] = {position.x(), position.y(), position.z()};
  json["orientation"] = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
}

void AddQuality(const MarkerPose& marker, Json& json) {
  json["corners_used"] = marker.corners_used;
  json["reprojection_rms_px"] = marker.reprojection_rms_px;
  if (marker.has_pose) {
    json["covariance"] = UpperTriangle(marker.covariance);
    json["ambiguity"] = marker.ambiguity;
  }
  json["luminance_overlap"] = marker.luminance_overlap;
  json["saturation_overlap"] = marker.saturation_overlap;
  json["bits_corrected"] = marker.bits_corrected;
  json["warnings"] = Json::array();
  for (const Warning warning : kAllWarnings)
    if (marker.Has(warning)) json["warnings"].push_back(WarningName(warning));
}

std::string WarningNames(const MarkerPose& marker, std::string_view separator) {
  std::string names;
  for (const Warning warning : kAllWarnings)
    if (marker.Has(warning)) names.append(names.empty() ? "" : separator).append(WarningName(warning));
  return names;
}

}  // namespace chequer
