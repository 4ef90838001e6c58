#include "robot/robot_roster.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "core/toml_reader.h"

namespace chequer {
namespace {

using MarkerKey = std::pair<int, std::uint64_t>;  ///< family and id

constexpr NumberRange kMetres{-10, 10};
constexpr NumberRange kHeight{0, 10};
constexpr NumberRange kSide{0.001, 99};  // as in [[marker]]
constexpr NumberRange kDegrees{-360, 360};
constexpr double kRadPerDegree = std::numbers::pi / 180;

Eigen::Vector3d ReadPosition(TomlTable& table) {
  std::vector<double> numbers;
  if (!table.ReadLengths("position", numbers, LengthRange{3, 3}, kMetres)) table.FailMissing("position");
  return {numbers[0], numbers[1], numbers[2]};
}

Eigen::Quaterniond ReadRotation(TomlTable& table) {
  double heading_deg = 0;
  const bool has_heading = table.Read("heading", heading_deg, kDegrees);
  std::vector<double> q;
  if (!table.Read("orientation", q, LengthRange{4, 4}, NumberRange{-1, 1}))
    return RotationFromVector({0, 0, heading_deg * kRadPerDegree});
  if (has_heading) table.Fail("orientation", "and heading exclude each other; give one of them");
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3))
    table.Fail("orientation", "must be a unit quaternion w x y z, such as [1, 0, 0, 0]");
  return rotation.normalized();
}

/// Of a board as printed: width and height, or the longer side of a board of square cells.
std::optional<Eigen::Vector2d> ReadPrinted(TomlTable& table, const MarkerFamily& family) {
  if (!table.HoldsList("side")) {
    double side_m = 0;
    if (!table.ReadLength("side", side_m, kSide)) return std::nullopt;
    const MarkerSize size = family.code.size();
    return side_m / std::max(size.rows, size.cols) * Eigen::Vector2d(size.cols, size.rows);
  }
  std::vector<double> printed;
  table.ReadLengths("side", printed, LengthRange{2, 2}, kSide);
  const Eigen::Vector2d printed_m(printed[0], printed[1]);
  if (!family.IsPrint(printed_m)) table.Fail("side", "must be [width, height] of a board of nearly square cells");
  return printed_m;
}

/// The keys of a marker but its position.
RosterMarker ReadMarker(TomlTable& table, std::span<const MarkerFamily> families) {
  RosterMarker marker;
  table.Require("id", marker.id, IntegerRange{0, INT64_MAX});
  table.Read("family", marker.family, IntegerRange{0, 63});
  if (static_cast<std::size_t>(marker.family) >= families.size())
    table.Fail("family", "must be below " + std::to_string(families.size()) + ", the number of kinds that are sought");
  const MarkerFamily& family = families[static_cast<std::size_t>(marker.family)];
  const std::uint64_t largest = family.code.max_id();
  if (marker.id > largest)
    table.Fail("id", "is beyond " + std::to_string(largest) + ", the largest id of this kind of marker");
  marker.body_from_marker.rotation = ReadRotation(table);
  marker.printed_m = ReadPrinted(table, family);
  return marker;
}

std::string ReadName(TomlTable& table) {
  std::string name;
  table.Require("name", name, LengthRange{1, 64});
  const bool printable =
      std::none_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (!printable) table.Fail("name", "must have no control characters");
  return name;
}

RosterRobot ReadRobot(TomlTable& table, std::span<const MarkerFamily> families) {
  RosterRobot robot;
  robot.name = ReadName(table);
  double height_m = 0;
  const bool has_height = table.ReadLength("height", height_m, kHeight);
  std::vector<TomlTable> tables = table.Tables("marker", kMaxMarkersOnRobot);
  if (tables.empty()) {
    if (!table.Has("id")) table.Fail("id", "is missing: a robot needs the id of its marker, or two [[robot.marker]]");
    RosterMarker marker = ReadMarker(table, families);
    if (!has_height && !table.Has("position"))
      table.Fail("height", "is missing: the height of the marker's centre over the floor, or its position, in metres");
    marker.body_from_marker.translation = table.Has("position") ? ReadPosition(table) : Eigen::Vector3d(0, 0, height_m);
    robot.markers.push_back(marker);
  } else {
    if (tables.size() != kMaxMarkersOnRobot)
      table.Fail("marker", "must be two [[robot.marker]]; the keys of a single marker stand in [[robot]] itself");
    for (TomlTable& marker_table : tables) {
      robot.markers.push_back(ReadMarker(marker_table, families));
      robot.markers.back().body_from_marker.translation = ReadPosition(marker_table);
    }
    for (const char* key : {"id", "family", "side", "position", "heading", "orientation"})
      if (table.Has(key)) table.Fail(key, "belongs into [[robot.marker]], where a robot has two");
  }
  if (has_height) robot.body_height_m = height_m - robot.markers.front().body_from_marker.translation.z();
  return robot;
}

MarkerKey KeyOf(const RosterMarker& marker) { return {marker.family, marker.id}; }

/// Refuses a robot that cannot be told from those before it.
class Distinct {
 public:
  void Add(const TomlTable& table, const RosterRobot& robot) {
    if (!names_.insert(robot.name).second) table.Fail("name", "stands twice; every robot needs a name of its own");
    std::set<MarkerKey> keys;
    for (const RosterMarker& marker : robot.markers) keys.insert(KeyOf(marker));
    const char* at = table.Has("id") ? "id" : "marker";
    if (keys.size() != robot.markers.size()) table.Fail(at, "must have two different ids");
    if (const auto [other, is_new] = robots_.emplace(keys, robot.name); !is_new)
      table.Fail(at, "cannot tell '" + robot.name + "' from '" + other->second + "', which bears the same");
    CheckPrints(table, robot);
    for (const MarkerKey& key : keys) {
      const bool alone = keys.size() == 1;
      const auto [other, is_new] = bearers_.emplace(key, Bearer{robot.name, alone});
      if (!is_new && (alone || other->second.alone))
        table.Fail(at, "id " + std::to_string(key.second) + " is also on '" + other->second.name +
                           "'; only robots with two markers may share an id");
    }
  }

 private:
  /// A marker has one print: which robot bears it is not known before it is measured.
  void CheckPrints(const TomlTable& table, const RosterRobot& robot) {
    for (const RosterMarker& marker : robot.markers)
      if (const auto [print, is_new] = prints_.emplace(KeyOf(marker), marker.printed_m);
          print->second != marker.printed_m)
        table.Fail(table.Has("id") ? "id" : "marker",
                   "id " + std::to_string(marker.id) + " has another side on another robot; give both the same");
  }

  struct Bearer {
    std::string name;
    bool alone = false;  ///< it is its only marker
  };
  std::set<std::string> names_;
  std::map<std::set<MarkerKey>, std::string> robots_;
  std::map<MarkerKey, Bearer> bearers_;
  std::map<MarkerKey, std::optional<Eigen::Vector2d>> prints_;
};

RobotRoster ReadRoster(TomlFile file, std::span<const MarkerFamily> families) {
  TomlTable root = file.root();
  std::vector<TomlTable> tables = root.Tables("robot", kMaxRobots);
  if (tables.empty()) root.Fail("robot", "is missing: a roster needs at least one [[robot]] with name and id");
  RobotRoster roster;
  Distinct distinct;
  for (TomlTable& table : tables) {
    roster.robots.push_back(ReadRobot(table, families));
    distinct.Add(table, roster.robots.back());
  }
  file.CheckAllKeysRead();
  return roster;
}

}  // namespace

void SetPrints(const RobotRoster& roster, std::span<MarkerFamily> families) {
  for (MarkerFamily& family : families) family.printed_by_id_m.clear();
  for (const RosterRobot& robot : roster.robots)
    for (const RosterMarker& marker : robot.markers)
      if (marker.printed_m)
        families[static_cast<std::size_t>(marker.family)].printed_by_id_m[marker.id] = *marker.printed_m;
}

RobotRoster LoadRobotRoster(const std::filesystem::path& path, std::span<const MarkerFamily> families) {
  return ReadRoster(TomlFile::Load(path), families);
}

RobotRoster ParseRobotRoster(std::string_view text, const std::string& name, std::span<const MarkerFamily> families) {
  return ReadRoster(TomlFile::Parse(text, name), families);
}

}  // namespace chequer
