#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "chequer/detector.h"
#include "robot/robot_roster.h"

namespace chequer {

/// What frames say of how high a marker is over the floor.
struct MarkerHeight {
  double height_m = 0;  ///< of its centre: median over the frames
  double spread_m = 0;  ///< median distance of single frames from that
  double tilt_rad = 0;  ///< of its face against the floor: median over the frames
  int frames = 0;
};

/// Measures the heights of robots' markers while the robots stand or drive about on the floor: the value of a roster
/// that is hardest to measure by hand, and that decides how exact floor poses are.
class MarkerSurvey {
 public:
  explicit MarkerSurvey(const RigidTransform& world_from_camera) : world_from_camera_(world_from_camera) {}

  /// Takes the markers of one frame, with poses in the camera frame; those without an id or a pose are passed over.
  void Add(std::span<const MarkerPose> markers);

  /// By family and id.
  std::map<std::pair<int, std::uint64_t>, MarkerHeight> Heights() const;

 private:
  struct Samples {
    std::vector<double> heights_m, tilts_rad;
  };
  RigidTransform world_from_camera_;
  std::map<std::pair<int, std::uint64_t>, Samples> samples_;
};

/// Adds a robot for each marker that was seen and that no robot bears, named robot_<id> (robot_<family>_<id> beyond the
/// first family), whose origin is on the floor below its marker and whose heading is the marker's.
void AddNewcomers(RobotRoster& roster, const std::map<std::pair<int, std::uint64_t>, MarkerHeight>& heights);

/// A roster of newcomers alone.
RobotRoster RosterOf(const std::map<std::pair<int, std::uint64_t>, MarkerHeight>& heights);

/// A roster with the heights of its markers as measured; those that were not seen stay.
RobotRoster WithHeights(RobotRoster roster, const std::map<std::pair<int, std::uint64_t>, MarkerHeight>& heights);

}  // namespace chequer
