#include "publish/wire_robots.h"

#include "publish/wire_header.h"
#include "publish/wire_values.h"

namespace chequer {
namespace {

using wire_values::FromMicroseconds;
using wire_values::IsText;
using wire_values::kNaN;
using wire_values::Microseconds;
using wire_values::ReadHeader;
using wire_values::ReadRotation;
using wire_values::ReadTriangle;
using wire_values::ReadVector;
using wire_values::Signed;
using wire_values::Unsigned;
using wire_values::WriteHeader;
using wire_values::WriteRotation;
using wire_values::WriteTriangle;
using wire_values::WriteVector;

void WriteFloor(const std::optional<FloorPose>& floor, robot_pose_t& wire) {
  const bool valid = floor.has_value();
  wire.floor_valid = valid;
  for (int i = 0; i < 2; ++i) wire.floor_position[i] = valid ? floor->position(i) : kNaN;
  wire.floor_heading = valid ? floor->heading_rad : kNaN;
  WriteTriangle(valid ? floor->covariance : Eigen::Matrix3d(Eigen::Matrix3d::Constant(kNaN)), wire.floor_covariance);
  wire.floor_height_error = static_cast<float>(valid ? floor->height_error_m : kNaN);
  wire.floor_tilt = static_cast<float>(valid ? floor->tilt_rad : kNaN);
  wire.floor_chi_square = static_cast<float>(valid ? floor->chi_square : kNaN);
  wire.off_floor = valid && floor->off_floor;
}

FloorPose ReadFloor(const robot_pose_t& wire) {
  FloorPose floor;
  floor.position = {wire.floor_position[0], wire.floor_position[1]};
  floor.heading_rad = wire.floor_heading;
  ReadTriangle(wire.floor_covariance, floor.covariance);
  floor.height_error_m = static_cast<double>(wire.floor_height_error);
  floor.tilt_rad = static_cast<double>(wire.floor_tilt);
  floor.chi_square = static_cast<double>(wire.floor_chi_square);
  floor.off_floor = wire.off_floor != 0;
  return floor;
}

void WriteRobot(const RobotPose& robot, robot_pose_t& wire) {
  wire.name = robot.name;
  wire.marker_count = static_cast<std::int8_t>(robot.marker_count);
  for (int i = 0; i < kMaxMarkersOnRobot; ++i) wire.marker_ids[i] = Signed(robot.ids[static_cast<std::size_t>(i)]);
  wire.family = static_cast<std::int16_t>(robot.family);
  WriteVector(robot.frame_from_body.translation, wire.position);
  WriteRotation(robot.frame_from_body.rotation, wire.orientation);
  WriteTriangle(robot.covariance, wire.covariance);
  wire.ambiguity = static_cast<float>(robot.ambiguity);
  WriteFloor(robot.floor, wire);
}

bool ReadRobot(const robot_pose_t& wire, RobotPose& robot) {
  if (wire.marker_count < 0 || wire.marker_count > kMaxMarkersOnRobot || wire.family < 0 || !IsText(wire.name))
    return false;
  robot.name = wire.name;
  robot.marker_count = wire.marker_count;
  for (int i = 0; i < kMaxMarkersOnRobot; ++i) robot.ids[static_cast<std::size_t>(i)] = Unsigned(wire.marker_ids[i]);
  robot.family = wire.family;
  robot.frame_from_body = {ReadRotation(wire.orientation), ReadVector(wire.position)};
  ReadTriangle(wire.covariance, robot.covariance);
  robot.ambiguity = static_cast<double>(wire.ambiguity);
  if (wire.floor_valid != 0) robot.floor = ReadFloor(wire);
  return true;
}

void WriteTrack(const TrackState& track, track_t& wire) {
  wire.name = track.key.robot;
  wire.marker_id = Signed(track.key.id);
  wire.family = static_cast<std::int16_t>(track.key.family);
  WriteVector(track.frame_from_body.translation, wire.position);
  WriteRotation(track.frame_from_body.rotation, wire.orientation);
  wire.heading = HeadingRad(track.frame_from_body.rotation);
  WriteVector(track.velocity, wire.velocity);
  WriteVector(track.angular_velocity, wire.angular_velocity);
  WriteTriangle(track.covariance.topLeftCorner<6, 6>(), wire.pose_covariance);
  WriteTriangle(track.covariance.bottomRightCorner<6, 6>(), wire.velocity_covariance);
  wire.age_us = track.age.count();
  wire.since_seen_us = track.since_seen.count();
  wire.coasting = track.coasting;
  wire.poses_used = Signed(track.poses_used);
  wire.poses_refused = Signed(track.poses_refused);
}

bool ReadTrack(const track_t& wire, TrackState& track) {
  if (wire.family < 0 || !IsText(wire.name)) return false;
  track.key = {wire.name, wire.family, Unsigned(wire.marker_id)};
  track.frame_from_body = {ReadRotation(wire.orientation), ReadVector(wire.position)};
  track.velocity = ReadVector(wire.velocity);
  track.angular_velocity = ReadVector(wire.angular_velocity);
  ReadTriangle(wire.pose_covariance, track.covariance.topLeftCorner<6, 6>());
  ReadTriangle(wire.velocity_covariance, track.covariance.bottomRightCorner<6, 6>());
  track.age = std::chrono::microseconds(wire.age_us);
  track.since_seen = std::chrono::microseconds(wire.since_seen_us);
  track.coasting = wire.coasting != 0;
  track.poses_used = Unsigned(wire.poses_used);
  track.poses_refused = Unsigned(wire.poses_refused);
  return true;
}

}  // namespace

void Write(const RobotsMessage& message, robots_t& wire) {
  WriteHeader(message.header, wire);
  wire.robot_count = static_cast<std::int32_t>(message.robots.size());
  wire.robots.resize(message.robots.size());
  for (std::size_t i = 0; i < message.robots.size(); ++i) WriteRobot(message.robots[i], wire.robots[i]);
}

void Write(const TracksMessage& message, tracks_t& wire) {
  WriteHeader(message.header, wire);
  wire.valid_utc_us = Microseconds(message.valid_utc);
  wire.valid_monotonic_us = Microseconds(message.valid_monotonic);
  wire.track_count = static_cast<std::int32_t>(message.tracks.size());
  wire.tracks.resize(message.tracks.size());
  for (std::size_t i = 0; i < message.tracks.size(); ++i) WriteTrack(message.tracks[i], wire.tracks[i]);
}

std::optional<RobotsMessage> Read(const robots_t& wire) {
  RobotsMessage message;
  if (!ReadHeader(wire, message.header)) return std::nullopt;
  message.robots.resize(wire.robots.size());
  for (std::size_t i = 0; i < wire.robots.size(); ++i)
    if (!ReadRobot(wire.robots[i], message.robots[i])) return std::nullopt;
  return message;
}

std::optional<TracksMessage> Read(const tracks_t& wire) {
  TracksMessage message;
  if (!ReadHeader(wire, message.header)) return std::nullopt;
  message.valid_utc = FromMicroseconds<UtcTime>(wire.valid_utc_us);
  message.valid_monotonic = FromMicroseconds<MonotonicTime>(wire.valid_monotonic_us);
  message.tracks.resize(wire.tracks.size());
  for (std::size_t i = 0; i < wire.tracks.size(); ++i)
    if (!ReadTrack(wire.tracks[i], message.tracks[i])) return std::nullopt;
  return message;
}

}  // namespace chequer
