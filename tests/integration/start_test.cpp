// `chequer start` from end to end: a rendered lab is its camera, and the answers are typed ahead.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "chequer/camera_file.h"
#include "robot/robot_roster.h"
#include "support/process.h"
#include "support/temporary_directory.h"
#include "world/world_file.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;
using test::Process;
using test::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A folder with a lab in it: frames of the sheet for the lens, and of a room with eight robots.
class Lab {
 public:
  Lab() {
    std::ofstream(*this / "room.toml") << "[[reference]]\nid = 8\nposition = [0, 0]\n"
                                          "[[reference]]\nid = 9\nposition = [1.2, 0]\n"
                                          "[[reference]]\nid = 10\nposition = [0, 1.0]\n";
    Must(
        "render --marker 6x6:secded:30mm --ids 2028-2047 --sheet --frames 40 --fps 5 --size 1280x960 --focal 1100 "
        "--background wood --out sheet");
    Must(
        "render --marker 6x6:secded:60mm --ids 0-10 --room room.toml --distance 2 --frames 40 --fps 20 "
        "--size 1280x960 --focal 1100 --speed 0.1 --out room");
  }
  fs::path operator/(const std::string& name) const { return folder_.path() / name; }

  /// Runs a line of a shell in the folder, where `chequer` and `chequerd` are at hand.
  test::RunResult Shell(const std::string& line) const {
    const std::string bin = fs::path(CHEQUER).parent_path().string();
    Process shell({"/bin/sh", "-c", "cd '" + folder_.path().string() + "' && PATH='" + bin + "':$PATH && " + line});
    const auto status = shell.Wait(std::chrono::seconds(110));
    return {status.value_or(-1), shell.output()};
  }
  void Must(const std::string& command) const {
    const test::RunResult result = Shell("chequer " + command);
    ASSERT_EQ(result.status, 0) << command << "\n" << result.output;
  }
  std::string TextOf(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(*this / name).rdbuf();
    return text.str();
  }

 private:
  TemporaryDirectory folder_;
};

TEST(StartCommand, LeadsFromACameraToRobotsInTheRoom) {
  const Lab lab;
  // Enter for each step; the camera step asks for the side and the robots.
  const test::RunResult start = lab.Shell(
      "printf '\\n60mm\\n8\\n\\n\\n\\n\\n\\n' | chequer start --name north --recording room --lens-frames sheet");
  ASSERT_EQ(start.status, 0) << start.output;
  // What it did, and the plain commands.
  EXPECT_THAT(start.output,
              AllOf(HasSubstr("== camera"), HasSubstr("chequer print --config ./north.toml"),
                    HasSubstr("chequer calibrate lens --config ./north.toml --marker 6x6 --side 30mm"),
                    HasSubstr("chequer calibrate world --config ./north.toml --l 8,9,10"),
                    HasSubstr("chequer calibrate robots --config ./north.toml"), HasSubstr("systemctl enable --now")));
  EXPECT_GT(fs::file_size(lab / "north-markers.pdf"), 1000u);
  EXPECT_GT(fs::file_size(lab / "north-lens.pdf"), 1000u);

  // The lab as it was rendered.
  const CameraModel camera = LoadCamera(lab / "north-camera.toml");
  EXPECT_NEAR(camera.fx, 1100, 5.5);
  EXPECT_NEAR(camera.cx, 639.5, 5);
  const Eigen::Vector3d at = LoadWorld(lab / "north-world.toml").world_from_camera.translation;
  EXPECT_NEAR(at.x(), 0.6, 0.02);
  EXPECT_NEAR(at.y(), 0.5 - 2 * std::sin(0.17), 0.02);
  EXPECT_NEAR(at.z(), 2 * std::cos(0.17), 0.02);
  const MarkerFamily family{.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = 0.06, .roster = {}};
  const RobotRoster robots = LoadRobotRoster(lab / "north-robots.toml", std::span(&family, 1));
  ASSERT_EQ(robots.robots.size(), 8u);
  for (const RosterRobot& robot : robots.robots)
    EXPECT_NEAR(robot.markers.front().body_from_marker.translation.z(), 0.1, 0.01) << robot.name;

  // The configuration names all three, and chequerd takes it.
  EXPECT_THAT(lab.TextOf("north.toml"),
              AllOf(HasSubstr("\ncalibration = \"north-camera.toml\""), HasSubstr("\nfile = \"north-world.toml\""),
                    HasSubstr("\nfile = \"north-robots.toml\""), HasSubstr("[tracks]\nenabled = true")));
  const test::RunResult check = lab.Shell("chequerd --check --config north");
  EXPECT_EQ(check.status, 0) << check.output;

  // Each step again, alone. A configuration that is there is kept, an edited calibration too.
  std::ofstream(lab / "north.toml", std::ios::app) << "# mine\n";
  EXPECT_THAT(lab.Shell("chequer start camera --yes").output, HasSubstr("is there, and kept"));
  EXPECT_THAT(lab.TextOf("north.toml"), HasSubstr("# mine"));
  const test::RunResult world = lab.Shell("chequer start world --yes --references room.toml --world-frames room");
  EXPECT_EQ(world.status, 0) << world.output;
  EXPECT_THAT(world.output, AllOf(HasSubstr("room.toml"), Not(HasSubstr("== lens"))));
  std::ofstream(lab / "north-camera.toml", std::ios::app) << "# mine\n";
  const test::RunResult lens = lab.Shell("chequer start lens --yes --lens-frames sheet");
  EXPECT_EQ(lens.status, 1);
  EXPECT_THAT(lens.output, AllOf(HasSubstr("--force"), HasSubstr("chequer start lens --name north")));
}

TEST(StartCommand, SaysWhatIsWrongBeforeItBegins) {
  const TemporaryDirectory folder;
  const auto start = [&](const std::string& words) {
    return test::RunToEnd({"/bin/sh", "-c", "cd '" + folder.path().string() + "' && '" CHEQUER "' start " + words});
  };
  EXPECT_EQ(start("lense --yes").status, 2);
  EXPECT_THAT(start("lense --yes").output, HasSubstr("did you mean 'lens'?"));
  EXPECT_THAT(start("--yes --name 'a b'").output, HasSubstr("--name"));
  EXPECT_THAT(start("--yes --robots 5000").output, HasSubstr("1 to 2000"));
  EXPECT_THAT(start("--yes --folder /nowhere").output, HasSubstr("is no folder"));
  EXPECT_THAT(start("lens --yes").output, HasSubstr("chequer start camera"));
  // Questions that nobody answers.
  EXPECT_THAT(start("--recording x </dev/null").output, HasSubstr("the answers ended"));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace chequer
