#pragma once

#include <cstddef>
#include <vector>

#include "chequer/geometry.h"
#include "simulate/scenario.h"
#include "simulate/scene.h"
#include "simulate/traffic.h"

namespace chequer {

/// The robots of a scenario, seen by a camera that hangs level.
class Robots {
 public:
  /// Throws std::runtime_error saying how many robots find room where not all do.
  explicit Robots(const Scenario& scenario);

  std::size_t size() const { return bodies_.size(); }

  /// level_camera_from_marker at a time since the stream began.
  RigidTransform PoseAt(std::size_t robot, double time_s) const;

  /// What a robot carries; its pose is not set.
  const SceneMarker& Marker(std::size_t robot) const { return bodies_[robot].marker; }

 private:
  struct Body {
    SceneMarker marker;
    double depth_m = 0;  ///< from the camera, along its axis
    double tilt_rad = 0;
    double tilt_axis_rad = 0;  ///< against the heading
  };

  static std::vector<Body> MakeBodies(const Scenario& scenario);

  double distance_m_;
  std::vector<Body> bodies_;
  Traffic traffic_;  ///< on the floor, as the camera sees it there
};

}  // namespace chequer
