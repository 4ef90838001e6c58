#include <array>
#include <charconv>

#include "core/file.h"
#include "robot/robot_roster.h"

namespace chequer {
namespace {

/// The shortest text that reads back as the same number.
std::string Exact(double number) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

/// A TOML string; names have no control characters.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' || c == '\\' ? "\\" : "").push_back(c);
  return quoted + "\"";
}

std::string MarkerText(const RosterMarker& marker) {
  const Eigen::Vector3d& t = marker.body_from_marker.translation;
  const Eigen::Quaterniond q = Canonical(marker.body_from_marker.rotation);
  std::string text = "id = " + std::to_string(marker.id) + "\n";
  if (marker.family != 0) text += "family = " + std::to_string(marker.family) + "\n";
  if (const auto& printed = marker.printed_m)
    text += "side = [" + Exact(printed->x()) + ", " + Exact(printed->y()) + "]\n";
  text += "position = [" + Exact(t.x()) + ", " + Exact(t.y()) + ", " + Exact(t.z()) + "]\n";
  if (q.w() == 1) return text;
  return text + "orientation = [" + Exact(q.w()) + ", " + Exact(q.x()) + ", " + Exact(q.y()) + ", " + Exact(q.z()) +
         "]\n";
}

}  // namespace

std::string FormatRobotRoster(const RobotRoster& roster) {
  std::string text;
  for (const RosterRobot& robot : roster.robots) {
    text += "[[robot]]\nname = " + Quoted(robot.name) + "\n";
    const double height_m = robot.body_height_m + robot.markers.front().body_from_marker.translation.z();
    if (robot.body_height_m != 0) text += "height = " + Exact(height_m) + "\n";
    if (robot.markers.size() == 1)
      text += MarkerText(robot.markers.front());
    else
      for (const RosterMarker& marker : robot.markers) text += "[[robot.marker]]\n" + MarkerText(marker);
    text += "\n";
  }
  return text;
}

void WriteRobotRoster(const std::filesystem::path& path, const RobotRoster& roster) {
  WriteFileAtomically(path, FormatRobotRoster(roster));
}

}  // namespace chequer
