#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/geometry.h"
#include "simulate/scene.h"

namespace chequer::test {

// A room with an overhead camera that is tilted and whose lens bends straight lines, markers at known places on the
// floor, and 40 robots that drive. World frame: metres, z up from the floor. Nothing of it is known to the programs
// under test but the frames and the lists that a user would write.

inline constexpr int kRobots = 40;
inline constexpr std::uint64_t kFirstReferenceId = 100;
inline constexpr std::uint64_t kFirstSheetId = 200;
/// Side of every marker: robots', references' and the sheet's.
inline constexpr double kRoomSideM = 0.12;

CameraModel RoomCamera();
RigidTransform WorldFromRoomCamera();

/// What a robot does at an instant.
struct RobotState {
  /// The marker that it carries lies flat, RobotHeightM over the floor, x ahead.
  RigidTransform world_from_marker;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< world frame
  double yaw_rate_rad_s = 0;                               ///< about the world's z
};

/// Height of a robot's marker over the floor, metres. @param robot 0 … kRobots − 1, also the marker's id.
double RobotHeightM(int robot);
/// From 0 to 2 s; later they leave the room.
RobotState RobotAt(int robot, std::chrono::duration<double> time);

/// A marker at a known place on the floor.
struct RoomReference {
  std::uint64_t id = 0;
  Eigen::Vector3d position_in_world;
  double heading_rad = 0;
};
std::vector<RoomReference> RoomReferences();

/// Writes a recording of a sheet of markers that somebody shows to a camera: the room's, or another.
void RecordSheet(const std::filesystem::path& folder, int views, std::uint64_t seed,
                 const CameraModel& camera = RoomCamera());

/// Writes a recording of the references on the empty floor.
void RecordReferences(const std::filesystem::path& folder, int frames, std::uint64_t seed);

/// Writes a recording of the robots that drive, the references among them, with their truth.
void RecordDrive(const std::filesystem::path& folder, int frames, double fps, std::uint64_t seed);

/// Writes the list of references that a user would write, for `chequer calibrate world`.
void WriteReferenceList(const std::filesystem::path& file);

}  // namespace chequer::test
