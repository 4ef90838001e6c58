#include "robot/marker_survey.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/median.h"

namespace chequer {

void MarkerSurvey::Add(std::span<const MarkerPose> markers) {
  for (const MarkerPose& marker : markers) {
    if (!marker.id || !marker.has_pose) continue;
    const RigidTransform world_from_marker = world_from_camera_ * marker.camera_from_marker;
    const Eigen::Vector3d face = world_from_marker.rotation * Eigen::Vector3d::UnitZ();
    Samples& samples = samples_[{marker.family, *marker.id}];
    samples.heights_m.push_back(world_from_marker.translation.z());
    samples.tilts_rad.push_back(std::acos(std::clamp(face.z(), -1.0, 1.0)));
  }
}

std::map<std::pair<int, std::uint64_t>, MarkerHeight> MarkerSurvey::Heights() const {
  std::map<std::pair<int, std::uint64_t>, MarkerHeight> heights;
  for (const auto& [key, samples] : samples_) {
    MarkerHeight& height = heights[key];
    height.height_m = Median(samples.heights_m);
    height.tilt_rad = Median(samples.tilts_rad);
    height.frames = static_cast<int>(samples.heights_m.size());
    std::vector<double> distances;
    for (const double sample : samples.heights_m) distances.push_back(std::abs(sample - height.height_m));
    height.spread_m = Median(std::move(distances));
  }
  return heights;
}

void AddNewcomers(RobotRoster& roster, const std::map<std::pair<int, std::uint64_t>, MarkerHeight>& heights) {
  std::set<std::pair<int, std::uint64_t>> known;
  std::set<std::string> names;
  for (const RosterRobot& robot : roster.robots) {
    names.insert(robot.name);
    for (const RosterMarker& marker : robot.markers) known.insert({marker.family, marker.id});
  }
  for (const auto& [key, height] : heights) {
    if (known.contains(key)) continue;
    const auto& [family, id] = key;
    RosterRobot robot;
    robot.name = "robot_" + (family == 0 ? "" : std::to_string(family) + "_") + std::to_string(id);
    while (!names.insert(robot.name).second) robot.name += "_new";
    RosterMarker marker{.id = id, .family = family, .body_from_marker = {}};
    marker.body_from_marker.translation.z() = height.height_m;
    robot.markers.push_back(marker);
    roster.robots.push_back(std::move(robot));
  }
}

RobotRoster RosterOf(const std::map<std::pair<int, std::uint64_t>, MarkerHeight>& heights) {
  RobotRoster roster;
  AddNewcomers(roster, heights);
  return roster;
}

RobotRoster WithHeights(RobotRoster roster, const std::map<std::pair<int, std::uint64_t>, MarkerHeight>& heights) {
  for (RosterRobot& robot : roster.robots)
    for (RosterMarker& marker : robot.markers)
      if (const auto seen = heights.find({marker.family, marker.id}); seen != heights.end())
        marker.body_from_marker.translation.z() = seen->second.height_m - robot.body_height_m;
  return roster;
}

}  // namespace chequer
