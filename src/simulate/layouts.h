#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/marker.h"
#include "simulate/print_quality.h"
#include "simulate/random.h"
#include "simulate/scene.h"

namespace chequer {

/// The camera of the publication's accuracy measurements: 640 × 480, f = 540.5 px, a wide lens.
CameraModel PublicationCamera();

/// The publication's straight tracks: 0.6 m, 0.9 m and 1.4 m away, and 0.9 m away inclined by 30°.
enum class TrackCase : std::uint8_t { kCloseDist, kMedDist, kFarDist, kInc30d };
/// "CloseDist", "MedDist", "FarDist", "Inc30d".
std::string_view TrackName(TrackCase track);

/// A marker of 0.12 m at eight places along a straight line in its own plane. The seed chooses id, heading and the
/// direction of the line.
std::vector<SceneMarker> PublicationTrack(TrackCase track, const MarkerCode& code, std::uint64_t seed);

/// A swarm under a camera that looks straight down.
struct SwarmOptions {
  CameraModel camera;
  std::vector<Board> boards;  ///< one a robot
  double side_m = 0.1;
  std::vector<double> sides_m{};  ///< one a board, where they differ; empty: all side_m
  double distance_m = 3;          ///< of the floor
  double height_spread_m = 0.1;   ///< robots are up to so much nearer
  double max_tilt_rad = 0.09;     ///< of a board against the floor
  double max_speed_m_s = 0.5;
  double gap_m = 0.01;  ///< kept free between boards
  InkSet inks;
  double margin_cells = 0;
  double ink_spread_cells = 0;
  PrintQuality print{};

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
  double SideOf(std::size_t board) const { return sides_m.empty() ? side_m : sides_m[board]; }
};

/// Robots that move, each within a circle of its own, on straight lines to and fro or on arcs, so that boards never
/// overlap and never leave the frame.
class Swarm {
 public:
  /// Throws std::runtime_error with Check's message, or saying how many robots find room where not all do.
  Swarm(SwarmOptions options, std::uint64_t seed);

  /// Where they are at a time since the start.
  std::vector<SceneMarker> At(std::chrono::duration<double> time) const;

 private:
  struct Robot {
    Eigen::Vector3d home = Eigen::Vector3d::Zero();  ///< middle of its circle, camera frame
    double roam_m = 0;                               ///< how far its middle moves from there
    double speed_m_s = 0;                            ///< along its path; the sign is the sense of turning
    double heading_rad = 0;                          ///< at the start
    double tilt_rad = 0;
    double tilt_axis_rad = 0;
    bool turns = false;
  };
  /// The room of one robot.
  struct Circle {
    Eigen::Vector3d home = Eigen::Vector3d::Zero();
    Eigen::Vector2d on_floor = Eigen::Vector2d::Zero();  ///< where its middle is seen on the floor, metres
    double floor_radius_m = 0;
  };

  void Place(std::uint64_t seed);
  SceneMarker PrintFor(std::size_t index, std::uint64_t seed) const;
  /// Gives robots places as long as there is room; how many have one.
  std::size_t TryPlace(double roam_m, std::uint64_t seed);
  std::optional<Circle> FindRoom(double radius_m, const std::vector<Circle>& taken, Random& random) const;
  SceneMarker MarkerAt(std::size_t index, double time_s) const;

  SwarmOptions options_;
  std::vector<SceneMarker> prints_;  ///< one a robot, without its pose
  std::vector<Robot> robots_;
};

}  // namespace chequer
