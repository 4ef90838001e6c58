#pragma once

#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "chequer/detector.h"
#include "core/robot_pose.h"
#include "robot/robot_roster.h"

namespace chequer {

struct RobotFinderOptions {
  RobotRoster roster;
  /// Where the camera stands; without it robots are given in the camera's frame.
  std::optional<RigidTransform> world_from_camera;
  bool floor_mode = false;  ///< needs world_from_camera
  /// A robot is off the floor beyond these, 0.001..10 m and 0.01..π rad.
  double max_height_error_m = 0.03;
  double max_tilt_rad = std::numbers::pi / 12;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// Tells which robots the markers of a frame are, and where their bodies are. Immutable, any thread.
class RobotFinder {
 public:
  /// Throws std::runtime_error with RobotFinderOptions::Check's message.
  explicit RobotFinder(RobotFinderOptions options);

  /// The robots of a frame, in the order of the roster; only markers with an id and a pose count. A robot with two
  /// markers is estimated from both where both are seen and fit its body, else from the one that it does not share with
  /// another robot. One whose only marker is seen twice is given twice: which one it is cannot be told from one frame.
  /// @param robots is replaced.
  void Find(std::span<const MarkerPose> markers, std::vector<RobotPose>& robots) const;

  /// Whether some robot bears a marker of that id.
  bool Knows(const MarkerPose& marker) const;

  const RobotFinderOptions& options() const { return options_; }

 private:
  /// Markers of the frame that may be a robot's first or second.
  struct Candidates {
    std::vector<const MarkerPose*> seen[kMaxMarkersOnRobot];
  };
  /// What is chosen of them; null where a marker is not seen.
  using Chosen = std::array<const MarkerPose*, kMaxMarkersOnRobot>;

  void FindPair(const RosterRobot& robot, const Candidates& candidates, std::vector<const MarkerPose*>& taken,
                std::vector<RobotPose>& robots) const;
  bool IsShared(const RosterMarker& marker) const;
  RobotPose Describe(const RosterRobot& robot, const Chosen& chosen) const;
  std::optional<FloorPose> DescribeFloor(const RosterRobot& robot, const Chosen& chosen,
                                         const RigidTransform& camera_from_body) const;

  RobotFinderOptions options_;
  /// Who bears a marker (family, id): index of the robot, and of the marker on it.
  std::multimap<std::pair<int, std::uint64_t>, std::pair<std::size_t, std::size_t>> bearers_;
};

}  // namespace chequer
