// The robots of the room as chequerd publishes them: named by a roster whose heights were measured from frames, on the
// floor, and followed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "core/robot_pose.h"
#include "integration/room_fixture.h"
#include "publish/lcm_log.h"
#include "robot/robot_roster.h"
#include "world/world_file.h"

namespace chequer::test {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
/// Frames after which a track knows its velocity.
constexpr std::uint64_t kSettled = 6;

/// Errors of one quantity.
class Errors {
 public:
  void Add(double error) { all_.push_back(std::abs(error)); }
  std::size_t count() const { return all_.size(); }
  double Rms() const {
    double sum = 0;
    for (const double error : all_) sum += error * error;
    return std::sqrt(sum / static_cast<double>(all_.size()));
  }
  double Worst() const { return *std::max_element(all_.begin(), all_.end()); }

 private:
  std::vector<double> all_;
};

std::ostream& operator<<(std::ostream& out, const Errors& errors) {
  return out << errors.Rms() << " rms, " << errors.Worst() << " worst of " << errors.count();
}

/// The number of a robot by its name, robot_<id>.
int NumberOf(const std::string& name) { return std::stoi(name.substr(std::string("robot_").size())); }

RobotState TruthOf(const std::string& name, std::uint64_t sequence) {
  return RobotAt(NumberOf(name), std::chrono::duration<double>(static_cast<double>(sequence) / kDriveFps));
}

/// The body's origin is on the floor below the marker.
Eigen::Vector3d OnFloor(const Eigen::Vector3d& position) { return {position.x(), position.y(), 0}; }

/// What chequerd published of the drive.
struct Published {
  std::vector<PosesMessage> in_world, in_camera;
  std::vector<RobotsMessage> robots;
  std::vector<TracksMessage> tracks;
  StatusMessage status;
};

Published ReadLog(const std::string& path) {
  Published published;
  LcmLogReader reader(path);
  while (auto record = reader.Next()) {
    if (auto* poses = std::get_if<PosesMessage>(&record->message))
      (record->channel.ends_with("_CAMERA") ? published.in_camera : published.in_world).push_back(std::move(*poses));
    if (auto* robots = std::get_if<RobotsMessage>(&record->message)) published.robots.push_back(std::move(*robots));
    if (auto* tracks = std::get_if<TracksMessage>(&record->message)) published.tracks.push_back(std::move(*tracks));
    if (auto* status = std::get_if<StatusMessage>(&record->message)) published.status = std::move(*status);
  }
  return published;
}

class RoomDrive : public Room {
 public:
  /// One run of chequerd over the drive, with the roster that the tool measured; the same for all tests.
  static const Published& Drive() {
    static const Published published = [] {
      Run({"calibrate", "robots", "--calibration", At("camera.toml"), "--world", At("world.toml"), "--side", "12cm",
           At("drive"), "--out", At("robots.toml")});
      return Play("world.toml", "robots.toml");
    }();
    return published;
  }

  /// What chequerd publishes of the drive. @param world_lines further ones of [world].
  static Published Play(const std::string& world, const std::string& roster, const std::string& world_lines = {}) {
    std::ofstream(At("chequerd.toml")) << "[camera]\nname = \"room\"\ncalibration = \"camera.toml\"\n"
                                          "[capture]\npath = \"drive\"\npace = \"unlimited\"\ntimes = \"recorded\"\n"
                                          "[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = 0.12\n"
                                          "[world]\nframes = \"both\"\nfile = \""
                                       << world << "\"\n"
                                       << world_lines << "[robots]\nfloor = true\nignore_others = true\nfile = \""
                                       << roster
                                       << "\"\n[tracks]\nenabled = true\nmotion = \"turning\"\n"
                                          "[publish]\nurl = \"file://"
                                       << At("log.lcm") << "?mode=w\"\n";
    Process daemon({CHEQUERD, "--config", At("chequerd.toml")});
    EXPECT_EQ(daemon.Wait(std::chrono::seconds(100)), 0) << daemon.output();
    return ReadLog(At("log.lcm"));
  }
};

TEST_F(Room, RobotsHeightsAreMeasuredFromFrames) {
  RoomDrive::Drive();
  std::vector<MarkerFamily> families{
      {.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = kRoomSideM, .roster = {}}};
  const RobotRoster roster = LoadRobotRoster(At("robots.toml"), families);
  EXPECT_EQ(roster.robots.size(), std::size_t{kRobots}) << "the world's references are no robots";
  Errors millimetres;
  for (const RosterRobot& robot : roster.robots)
    millimetres.Add(1000 * (robot.markers[0].body_from_marker.translation.z() - RobotHeightM(NumberOf(robot.name))));
  EXPECT_LT(millimetres.Worst(), 1) << millimetres;
  std::cout << "heights: " << millimetres << " mm\n";
}

TEST_F(Room, ASideThatTheWorldContradictsMeasuresNoHeights) {
  const std::string output =
      Run({"calibrate", "robots", "--calibration", At("camera.toml"), "--world", At("world.toml"), "--side", "10cm",
           "--frames", "3", At("drive"), "--out", At("wrong_side.toml")},
          1);
  EXPECT_THAT(output, ::testing::HasSubstr("100 mm here, but 120 mm in the world file"));
  EXPECT_FALSE(std::filesystem::exists(At("wrong_side.toml")));
}

TEST_F(Room, ARosterIsMeasuredAnewAndKeepsTheRest) {
  const std::vector<std::string> command{"calibrate",      "robots", "--calibration", At("camera.toml"), "--world",
                                         At("world.toml"), "--side", "12cm",          "--frames",        "3",
                                         At("drive")};
  const auto run = [&](const std::string& roster, int expected_status) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"--roster", At(roster), "--out", At("measured.toml")});
    return Run(arguments, expected_status);
  };
  std::ofstream(At("strangers.toml")) << "[[robot]]\nname = \"eve\"\nid = 999\nheight = 0.1\n";
  EXPECT_THAT(run("strangers.toml", 1), ::testing::HasSubstr("strangers.toml is seen"));
  EXPECT_FALSE(std::filesystem::exists(At("measured.toml")));
  std::ofstream(At("typed.toml")) << "[[robot]]\nname = \"alice\"\nid = 3\nheight = x\n";
  EXPECT_THAT(run("typed.toml", 1), ::testing::HasSubstr("typed.toml:4"));
  std::ofstream(At("named.toml")) << "[[robot]]\nname = \"alice\"\nid = 3\nposition = [0.01, 0, 0.5]\nheading = 90\n"
                                     "[[robot]]\nname = \"away\"\nid = 999\nheight = 0.1\n";
  EXPECT_THAT(run("named.toml", 0), ::testing::HasSubstr("not seen"));
  std::vector<MarkerFamily> families{
      {.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = kRoomSideM, .roster = {}}};
  const RobotRoster roster = LoadRobotRoster(At("measured.toml"), families);
  ASSERT_EQ(roster.robots.size(), 2u);
  const RigidTransform& body_from_marker = roster.robots[0].markers[0].body_from_marker;
  EXPECT_EQ(roster.robots[0].name, "alice");
  EXPECT_EQ(body_from_marker.translation.x(), 0.01);
  EXPECT_NEAR(body_from_marker.translation.z(), RobotHeightM(3), 0.001);
  EXPECT_NEAR(HeadingRad(body_from_marker.rotation), std::numbers::pi / 2, 1e-9);
  EXPECT_EQ(roster.robots[1].markers[0].body_from_marker.translation.z(), 0.1);
}

TEST_F(Room, AnEditedRosterKeepsItsNames) {
  const std::vector<std::string> command{"calibrate",      "robots", "--calibration",  At("camera.toml"), "--world",
                                         At("world.toml"), "--side", "12cm",           "--frames",        "3",
                                         At("drive"),      "--out",  At("edited.toml")};
  std::vector<MarkerFamily> families{
      {.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = kRoomSideM, .roster = {}}};
  Run(command);
  const std::size_t robots = LoadRobotRoster(At("edited.toml"), families).robots.size();
  EXPECT_THAT(Run(command), ::testing::Not(::testing::HasSubstr("edited:"))) << "what nobody edited is written anew";
  const std::string edited = "# ours\n[[robot]]\nname = \"alice\"\nid = 3\nposition = [0.01, 0, 0.5]\nheading = 90\n";
  std::ofstream(At("edited.toml")) << edited;
  EXPECT_THAT(Run(command), ::testing::HasSubstr("is kept as"));
  const RobotRoster roster = LoadRobotRoster(At("edited.toml"), families);
  ASSERT_EQ(roster.robots.size(), robots);
  EXPECT_EQ(roster.robots[0].name, "alice");
  EXPECT_EQ(roster.robots[0].markers[0].body_from_marker.translation.x(), 0.01);
  EXPECT_NEAR(roster.robots[0].markers[0].body_from_marker.translation.z(), RobotHeightM(3), 0.001);
  bool kept = false;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(At("edited.toml")).parent_path()))
    kept = kept || (entry.is_regular_file() && entry.file_size() == edited.size());
  EXPECT_TRUE(kept) << "with its comments";
  std::ofstream(At("edited.toml")) << "no roster\n";
  EXPECT_THAT(Run(command, 2), ::testing::HasSubstr("--force replaces it"));
}

TEST_F(Room, RobotsArePublishedInEveryFrame) {
  const Published& drive = RoomDrive::Drive();
  ASSERT_EQ(drive.robots.size(), std::size_t{kDriveFrames});
  ASSERT_EQ(drive.tracks.size(), std::size_t{kDriveFrames});
  for (std::size_t i = 0; i < drive.robots.size(); ++i) {
    EXPECT_EQ(drive.robots[i].header.frame, "world");
    EXPECT_GE(drive.robots[i].robots.size(), std::size_t{kRobots - 1}) << i;
    EXPECT_EQ(drive.tracks[i].tracks.size(), std::size_t{kRobots}) << i;
  }
  EXPECT_EQ(drive.status.camera_message, "") << "the references stand where they stood";
}

TEST_F(Room, AKnockedCameraIsTold) {
  // A world that was set before the camera was turned by a third of a degree.
  WorldCalibration before = LoadWorld(At("world.toml"));
  before.world_from_camera = before.world_from_camera * RigidTransform{RotationFromVector({0.006, 0, 0}), {0, 0, 0}};
  WriteWorld(At("knocked.toml"), before);
  RoomDrive::Drive();
  const Published drive = RoomDrive::Play("knocked.toml", "robots.toml", "drift_window = 0.1\n");
  EXPECT_THAT(drive.status.camera_message, ::testing::HasSubstr("the camera was moved"));
}

TEST_F(Room, ARobotThatIsNotOnTheFloorIsTold) {
  constexpr int kLifted = 7;
  constexpr double kLiftM = 0.04;
  RoomDrive::Drive();
  std::vector<MarkerFamily> families{
      {.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = kRoomSideM, .roster = {}}};
  RobotRoster roster = LoadRobotRoster(At("robots.toml"), families);
  for (RosterRobot& robot : roster.robots)
    if (NumberOf(robot.name) == kLifted) robot.markers[0].body_from_marker.translation.z() -= kLiftM;
  WriteRobotRoster(At("lifted.toml"), roster);
  const Published drive = RoomDrive::Play("world.toml", "lifted.toml");
  ASSERT_EQ(drive.robots.size(), std::size_t{kDriveFrames});
  int lifted = 0;
  for (const RobotsMessage& message : drive.robots)
    for (const RobotPose& robot : message.robots) {
      ASSERT_TRUE(robot.floor.has_value());
      EXPECT_EQ(robot.floor->off_floor, NumberOf(robot.name) == kLifted) << robot.name;
      if (NumberOf(robot.name) != kLifted) continue;
      EXPECT_NEAR(robot.floor->height_error_m, kLiftM, 0.002);
      EXPECT_NEAR(robot.frame_from_body.translation.z(), kLiftM, 0.002) << "the free pose is as it is";
      ++lifted;
    }
  EXPECT_GE(lifted, kDriveFrames - 1);
}

TEST_F(Room, RobotsFreePosesAreRight) {
  const Published& drive = RoomDrive::Drive();
  Errors millimetres, degrees;
  for (const RobotsMessage& message : drive.robots)
    for (const RobotPose& robot : message.robots) {
      const RigidTransform truth = TruthOf(robot.name, message.header.sequence).world_from_marker;
      millimetres.Add(1000 * (robot.frame_from_body.translation - OnFloor(truth.translation)).norm());
      degrees.Add(kDegrees * robot.frame_from_body.rotation.angularDistance(truth.rotation));
    }
  std::cout << "free: " << millimetres << " mm, " << degrees << " degrees\n";
  EXPECT_LT(millimetres.Worst(), 1);
  EXPECT_LT(degrees.Worst(), 0.2);
}

TEST_F(Room, RobotsFloorPosesAreRight) {
  const Published& drive = RoomDrive::Drive();
  Errors millimetres, degrees;
  for (const RobotsMessage& message : drive.robots)
    for (const RobotPose& robot : message.robots) {
      const RigidTransform truth = TruthOf(robot.name, message.header.sequence).world_from_marker;
      ASSERT_TRUE(robot.floor.has_value());
      EXPECT_FALSE(robot.floor->off_floor) << robot.name;
      millimetres.Add(1000 * (robot.floor->position - truth.translation.head<2>()).norm());
      degrees.Add(kDegrees *
                  std::remainder(robot.floor->heading_rad - HeadingRad(truth.rotation), 2 * std::numbers::pi));
    }
  std::cout << "floor: " << millimetres << " mm, " << degrees << " degrees\n";
  EXPECT_LT(millimetres.Worst(), 0.5);
  EXPECT_LT(degrees.Worst(), 0.1);
}

TEST_F(Room, RobotsVelocitiesAreRight) {
  const Published& drive = RoomDrive::Drive();
  Errors percent, yaw;
  for (const TracksMessage& message : drive.tracks) {
    if (message.header.sequence < kSettled) continue;
    for (const TrackState& track : message.tracks) {
      const RobotState truth = TruthOf(track.key.robot, message.header.sequence);
      percent.Add(100 * (track.velocity - truth.velocity_m_s).norm() / truth.velocity_m_s.norm());
      yaw.Add(track.angular_velocity.z() - truth.yaw_rate_rad_s);
      EXPECT_EQ(track.poses_refused, 0u) << track.key.robot;
    }
  }
  std::cout << "velocity: " << percent << " %, yaw rate: " << yaw << " rad/s\n";
  EXPECT_LT(percent.Worst(), 1);
  EXPECT_LT(yaw.Rms(), 0.02);
}

TEST_F(Room, RawPosesComeInBothFramesAndAreTheSame) {
  const Published& drive = RoomDrive::Drive();
  const RigidTransform world_from_camera = LoadWorld(At("world.toml")).world_from_camera;
  ASSERT_EQ(drive.in_world.size(), std::size_t{kDriveFrames});
  ASSERT_EQ(drive.in_camera.size(), drive.in_world.size());
  for (std::size_t i = 0; i < drive.in_world.size(); ++i) {
    EXPECT_EQ(drive.in_world[i].frame, "world");
    EXPECT_EQ(drive.in_camera[i].frame, "camera");
    ASSERT_EQ(drive.in_world[i].markers.size(), drive.in_camera[i].markers.size());
    for (std::size_t j = 0; j < drive.in_world[i].markers.size(); ++j) {
      const MarkerPose &world = drive.in_world[i].markers[j], &camera = drive.in_camera[i].markers[j];
      EXPECT_LT(world.id.value_or(0), std::uint64_t{kRobots}) << "others are ignored";
      const RigidTransform expected = world_from_camera * camera.camera_from_marker;
      EXPECT_LT((world.camera_from_marker.translation - expected.translation).norm(), 1e-9);
    }
  }
}

}  // namespace
}  // namespace chequer::test
