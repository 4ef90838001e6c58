// From frames alone to poses in the room: a lens, the world and the robots of a simulated room (support/room.h), by the
// commands a user would give.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "chequer/camera_file.h"
#include "integration/room_fixture.h"
#include "simulate/truth.h"
#include "world/drift_monitor.h"
#include "world/world_file.h"

namespace chequer::test {
namespace {

using ::testing::HasSubstr;

TEST_F(Room, LensIsFoundFromFramesOfASheet) {
  const CameraModel truth = RoomCamera(), found = LoadCamera(At("camera.toml"));
  EXPECT_NEAR(found.fx / truth.fx, 1, 0.001) << lens_output_;
  EXPECT_NEAR(found.fy / truth.fy, 1, 0.001);
  const auto record = LoadCalibrationRecord(At("camera.toml"));
  ASSERT_TRUE(record.has_value());
  EXPECT_LT(record->rms_px, 0.2);
  EXPECT_EQ(record->date.size(), 20u);
  // As wrong as it says it may be.
  EXPECT_LT(std::abs(found.fx - truth.fx), 4 * record->uncertainty[0]);
  EXPECT_GT(record->uncertainty[0], 0);
  EXPECT_LT(record->uncertainty[0], 0.001 * truth.fx);
  EXPECT_TRUE(std::filesystem::exists(At("camera.png")));
  EXPECT_THAT(lens_output_, HasSubstr("coverage"));
}

TEST_F(Room, WorldIsFoundFromFramesOfTheReferences) {
  const WorldCalibration world = LoadWorld(At("world.toml"));
  const RigidTransform truth = WorldFromRoomCamera();
  EXPECT_LT((world.world_from_camera.translation - truth.translation).norm(), 0.003) << world_output_;
  EXPECT_LT(world.world_from_camera.rotation.angularDistance(truth.rotation) * 180 / M_PI, 0.05);
  EXPECT_EQ(world.references.size(), RoomReferences().size());
  ASSERT_TRUE(world.rms_m.has_value());
  EXPECT_LT(*world.rms_m, 0.001);
}

TEST_F(Room, FisheyeLensIsFoundFromFramesToo) {
  CameraModel truth{.width = 1280, .height = 960, .fx = 561, .fy = 562, .cx = 633, .cy = 486};
  truth.kind = CameraModel::Kind::kFisheye;
  truth.distortion = {-0.02, 0.004, -0.001, 0.0002, 0};
  RecordSheet(At("fisheye"), 20, 5, truth);
  const std::string output = Run({"calibrate", "lens", "--model", "fisheye", "--side", "12cm", "--ids", "200-219",
                                  At("fisheye"), "--out", At("fisheye.toml"), "--picture", At("fisheye_picture.png")});
  const CameraModel found = LoadCamera(At("fisheye.toml"));
  EXPECT_EQ(found.kind, CameraModel::Kind::kFisheye);
  EXPECT_NEAR(found.fx / truth.fx, 1, 0.001) << output;
  EXPECT_NEAR(found.fy / truth.fy, 1, 0.001);
  EXPECT_TRUE(std::filesystem::exists(At("fisheye_picture.png")));
}

TEST_F(Room, WorldIsFoundFromAnLAndFromOneMarker) {
  const RigidTransform truth = WorldFromRoomCamera();
  const std::vector<std::string> common{"calibrate", "world",     "--calibration", At("camera.toml"),     "--side",
                                        "0.12",      At("empty"), "--out",         At("other_world.toml")};
  const auto run = [&](std::vector<std::string> way) {
    way.insert(way.begin(), common.begin(), common.end());
    Run(way);
    return LoadWorld(At("other_world.toml")).world_from_camera;
  };
  const RigidTransform of_l = run({"--l", "100,101,105"});
  EXPECT_LT((of_l.translation - truth.translation).norm(), 0.005);
  EXPECT_LT(of_l.rotation.angularDistance(truth.rotation) * 180 / M_PI, 0.2);
  // One marker of 12 cm tells directions no better than a few tenths of a degree.
  const RigidTransform of_one = run({"--origin", "100"});
  EXPECT_LT(of_one.rotation.angularDistance(truth.rotation) * 180 / M_PI, 1.5);
  EXPECT_LT((of_one.translation - truth.translation).norm(), 0.08);
}

TEST_F(Room, AContradictoryListNamesTheOffenderAndWritesNothing) {
  std::ifstream good(At("references.toml"));
  std::string text{std::istreambuf_iterator<char>(good), {}};
  const std::string place = "position = [2.6, 1.85, 0]";
  ASSERT_NE(text.find(place), std::string::npos) << text;
  std::ofstream(At("bad.toml")) << text.replace(text.find(place), place.size(), "position = [2.6, 1.58, 0]");
  const std::string output = Run({"calibrate", "world", "--calibration", At("camera.toml"), "--side", "12cm",
                                  "--references", At("bad.toml"), At("empty"), "--out", At("none.toml")},
                                 1);
  EXPECT_THAT(output, HasSubstr("bad.toml: reference 103 does not fit the other 7"));
  EXPECT_THAT(output, HasSubstr("(2.600, 1.580, 0.000)"));
  EXPECT_FALSE(std::filesystem::exists(At("none.toml")));
}

TEST_F(Room, AKnockedCameraIsNoticedByTheReferences) {
  // The detector's own poses of the references, against a world that was set before the camera was turned by a third of
  // a degree.
  WorldCalibration before = LoadWorld(At("world.toml"));
  const RigidTransform knock{RotationFromVector({0.006, 0, 0}), {0, 0, 0}};
  DriftMonitor still(before);
  before.world_from_camera = before.world_from_camera * knock;
  for (WorldReference& reference : before.references) reference.residual_m.setZero();
  DriftMonitor knocked(before);
  std::istringstream lines(
      Run({"detect", "--calibration", At("camera.toml"), "--marker", "6x6:secded:0.12", "--json", At("empty")}));
  std::optional<std::string> of_still, of_knocked;
  MonotonicTime now{std::chrono::seconds(5)};
  std::vector<std::vector<MarkerPose>> frames;
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json image = nlohmann::json::parse(line);
    std::vector<MarkerPose>& markers = frames.emplace_back();
    for (const auto& found : image["markers"]) {
      const auto t = found["position"].get<std::array<double, 3>>();
      const auto q = found["orientation"].get<std::array<double, 4>>();
      MarkerPose marker;
      marker.id = found["id"].get<std::uint64_t>();
      marker.has_pose = true;
      marker.camera_from_marker = {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]}};
      markers.push_back(marker);
    }
  }
  ASSERT_FALSE(frames.empty());
  for (int i = 0; i < 100; ++i) {
    now += std::chrono::milliseconds(100);
    const auto& markers = frames[static_cast<std::size_t>(i) % frames.size()];
    if (const auto said = still.Take(markers, now)) of_still = said;
    if (const auto said = knocked.Take(markers, now)) of_knocked = said;
  }
  EXPECT_FALSE(of_still.has_value()) << *of_still;
  ASSERT_TRUE(of_knocked.has_value());
  EXPECT_THAT(*of_knocked, HasSubstr("the camera was moved"));
}

TEST_F(Room, RobotsAreWhereTheyAre) {
  const RigidTransform world_from_camera = LoadWorld(At("world.toml")).world_from_camera;
  std::istringstream lines(
      Run({"detect", "--calibration", At("camera.toml"), "--marker", "6x6:secded:0.12", "--json", At("drive")}));
  double square_m = 0, square_rad = 0, worst_m = 0, worst_rad = 0;
  int count = 0;
  std::size_t frame = 0;
  for (std::string line; std::getline(lines, line); ++frame) {
    const nlohmann::json image = nlohmann::json::parse(line);
    for (const auto& marker : image["markers"]) {
      const int robot = marker["id"].get<int>();
      if (robot >= kRobots) continue;
      const auto t = marker["position"].get<std::array<double, 3>>();
      const auto q = marker["orientation"].get<std::array<double, 4>>();
      const RigidTransform camera_from_marker{Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]}};
      const RigidTransform found = world_from_camera * camera_from_marker;
      const RigidTransform truth =
          RobotAt(robot, std::chrono::duration<double>(static_cast<double>(frame) / 20)).world_from_marker;
      const double off_m = (found.translation - truth.translation).norm();
      const double off_rad = found.rotation.angularDistance(truth.rotation);
      square_m += off_m * off_m;
      square_rad += off_rad * off_rad;
      worst_m = std::max(worst_m, off_m);
      worst_rad = std::max(worst_rad, off_rad);
      ++count;
    }
  }
  EXPECT_EQ(frame, 10u);
  EXPECT_GE(count, 10 * kRobots - 1);
  const double rms_mm = 1000 * std::sqrt(square_m / count), rms_deg = std::sqrt(square_rad / count) * 180 / M_PI;
  RecordProperty("rms_mm", std::to_string(rms_mm));
  RecordProperty("rms_deg", std::to_string(rms_deg));
  RecordProperty("worst_mm", std::to_string(worst_m * 1000));
  RecordProperty("worst_deg", std::to_string(worst_rad * 180 / M_PI));
  EXPECT_LT(worst_m, 0.001);
  EXPECT_LT(worst_rad * 180 / M_PI, 0.2);
}

}  // namespace
}  // namespace chequer::test
