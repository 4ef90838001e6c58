#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/geometry.h"
#include "chequer/marker.h"

namespace chequer {

// The world frame: right-handed, metres, z up from the floor. A world file is what `chequer calibrate world` writes and
// the daemon reads:
//
//   [world]
//   position = [1.2, 0.8, 2.5]          # world_from_camera: the camera's centre of projection in the world, metres
//   orientation = [0, 1, 0, 0]          # and the rotation of camera axes into world axes, w x y z
//   covariance = [21 numbers]           # may be left out; upper triangle by rows of (x, y, z, θx, θy, θz) about world
//   axes rms = 0.0004                        # may be left out; of the references' residuals, metres date =
//   "2024-05-01T12:00:00Z"       # may be left out
//
//   [[world.reference]]                 # any number; watched for drift where they stay in view
//   id = 7
//   size = "6x6"
//   variant = "secded"
//   side = 0.12                         # metres
//   position = [0.0, 0.0, 0.0]          # world_from_marker as it was seen when the world was set, metres
//   orientation = [1, 0, 0, 0]
//   residual = [0.0002, 0.0001, 0.0]    # may be left out; seen minus said to be, metres

/// Most references of a world.
inline constexpr std::size_t kMaxReferences = 1000;

/// A marker that stood at a known place when the world was set.
struct WorldReference {
  std::uint64_t id = 0;
  MarkerSize size;
  Variant variant = Variant::kSecded;
  double side_m = 0;
  /// As it was seen then, so that camera_from_marker of that day is Inverse(world_from_camera) · world_from_marker.
  RigidTransform world_from_marker;
  /// Where it was seen minus where it was said to be, world frame, metres; 0 in what was not said.
  Eigen::Vector3d residual_m = Eigen::Vector3d::Zero();
};

/// Where a camera stands in the room.
struct WorldCalibration {
  RigidTransform world_from_camera;
  /// Of (x, y, z, θx, θy, θz) in the world frame, R_true = Exp(θ) · R; m², rad². Zero where it is not known.
  Matrix6d covariance = Matrix6d::Zero();
  /// Root mean square of the references' residuals, metres.
  std::optional<double> rms_m;
  std::string date;  ///< UTC, ISO 8601; may be empty
  std::vector<WorldReference> references;
};

/// Reads a world file. Throws std::runtime_error naming file, line, key, value and what would be right.
WorldCalibration LoadWorld(const std::filesystem::path& path);

/// The same from a text. @param name stands for the file in messages.
WorldCalibration ParseWorld(std::string_view text, const std::string& name);

/// The text of a world file; ParseWorld gives the same numbers back, to within the rounding of a quaternion.
std::string FormatWorld(const WorldCalibration& world);

/// Writes a world file whole or not at all. Throws std::runtime_error naming the file and the cause.
void WriteWorld(const std::filesystem::path& path, const WorldCalibration& world);

}  // namespace chequer
