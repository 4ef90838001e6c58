#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/detector.h"
#include "chequer/geometry.h"
#include "core/robot_pose.h"

namespace chequer {

// Which robots bear which markers, and where:
//
//   [[robot]]
//   name = "alice"                 # 1 to 64 characters, none of them a control character
//   id = 17                        # of the marker
//   height = 0.12                  # of the marker's centre over the floor, metres; left out: as in position
//   position = [0.02, 0.0, 0.12]   # of the marker's centre in the body's frame, metres; left out: [0, 0, height], a
//                                  # body whose origin lies on the floor below the marker
//   heading = 90                   # of the marker's x axis against the body's, degrees, counter-clockwise seen from
//                                  # above; left out: 0. Or, for a marker that does not lie flat:
//   #orientation = [1, 0, 0, 0]    # of marker axes in the body's frame, w x y z
//   family = 0                     # which [[marker]] of chequerd's configuration it is, counted from 0; left out: 0
//   side = [0.1204, 0.1198]        # width and height of its board as printed, metres, or one length; left out: as in
//                                  # that [[marker]]
//
//   [[robot]]                      # with two markers
//   name = "bob"
//   height = 0.2                   # of the first one; left out: as in its position
//   [[robot.marker]]
//   id = 3
//   position = [0.1, 0.0, 0.2]     # must be given
//   [[robot.marker]]
//   id = 4
//   position = [-0.1, 0.0, 0.2]
//   heading = 180
//
// The body's frame has x forward, y left, z up. Two robots may share ids as long as each has two markers and no other
// robot the same two: such a robot is known only where both are seen.

/// Most robots of a roster.
inline constexpr std::size_t kMaxRobots = 10'000;

/// A marker on a robot.
struct RosterMarker {
  std::uint64_t id = 0;
  int family = 0;
  RigidTransform body_from_marker;
  /// Width and height of its board, where its print is not as the others of the family.
  std::optional<Eigen::Vector2d> printed_m{};
};

struct RosterRobot {
  std::string name;
  std::vector<RosterMarker> markers;  ///< one or two
  double body_height_m = 0;           ///< of the body's origin over the floor, where the robot stands on it
};

struct RobotRoster {
  std::vector<RosterRobot> robots;
};

/// Reads a roster. Throws std::runtime_error naming file, line, key, value and what would be right; also where a name
/// stands twice, or ids do not tell two robots apart.
/// @param families what is sought: markers of other families, and ids that a family does not have, are refused.
RobotRoster LoadRobotRoster(const std::filesystem::path& path, std::span<const MarkerFamily> families);

/// The same from a text. @param name stands for the file in messages.
RobotRoster ParseRobotRoster(std::string_view text, const std::string& name, std::span<const MarkerFamily> families);

/// Gives the families the prints that a roster measures, in place of those they had. @pre it was read for them.
void SetPrints(const RobotRoster& roster, std::span<MarkerFamily> families);

/// The text of a roster; ParseRobotRoster gives the same numbers back.
std::string FormatRobotRoster(const RobotRoster& roster);

/// Writes a roster whole or not at all. Throws std::runtime_error naming the file and the cause.
void WriteRobotRoster(const std::filesystem::path& path, const RobotRoster& roster);

}  // namespace chequer
