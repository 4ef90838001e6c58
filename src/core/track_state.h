#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstdint>
#include <string>

#include "chequer/geometry.h"

namespace chequer {

using Matrix12d = Eigen::Matrix<double, 12, 12>;

/// Who is tracked: a robot of the roster by its name, any other marker by its id.
struct TrackKey {
  std::string robot;     ///< its name; empty without a roster
  int family = 0;        ///< of the marker
  std::uint64_t id = 0;  ///< of the marker; of a robot's first one
};

/// What a tracker knows of one robot at one time. All in the frame of the message, metres, radians, seconds.
struct TrackState {
  TrackKey key;
  RigidTransform frame_from_body;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  /// About the frame's axes; its z is the yaw rate.
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  /// Of (position, rotation θ with R_true = Exp(θ) · R, velocity, angular velocity), three numbers each.
  Matrix12d covariance = Matrix12d::Zero();

  std::chrono::microseconds age{};         ///< since its first pose
  std::chrono::microseconds since_seen{};  ///< since its last pose that was believed
  bool coasting = false;                   ///< this frame brought no pose that was believed
  std::uint64_t poses_used = 0;
  std::uint64_t poses_refused = 0;  ///< by the gate
};

}  // namespace chequer
