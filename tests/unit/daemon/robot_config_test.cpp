#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "chequer/camera_file.h"
#include "daemon/config.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "world/world_file.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A folder with a camera, a world and a roster, and configurations that name them.
class RobotConfig : public ::testing::Test {
 protected:
  RobotConfig() {
    CameraModel camera;
    camera.width = 640;
    camera.height = 480;
    WriteCamera(folder_ / "camera.toml", camera);
    WorldCalibration world;
    world.world_from_camera.translation = {1, 2, 3};
    WriteWorld(folder_ / "world.toml", world);
    std::ofstream(folder_ / "robots.toml") << "[[robot]]\nname = \"alice\"\nid = 3\nheight = 0.1\n";
  }

  DaemonConfig Parse(const std::string& tables, bool calibrated = true) const {
    return ParseDaemonConfig(std::string(calibrated ? "[camera]\ncalibration = \"camera.toml\"\n" : "\n\n") +
                                 "[capture]\npath = \"swarm\"\n[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\n"
                                 "side = 0.1\n" +
                                 tables,
                             "a.toml", folder_.path());
  }

  std::string Refusal(const std::string& tables, bool calibrated = true) const {
    return test::ErrorOf([&] { Parse(tables, calibrated); });
  }

  test::TemporaryDirectory folder_;
};

const std::string kWorld = "[world]\nfile = \"world.toml\"\n";
const std::string kRobots = "[robots]\nfile = \"robots.toml\"\n";

TEST_F(RobotConfig, RefusesASideThatTheWorldFileContradicts) {
  WorldCalibration world;
  WorldReference reference;
  reference.id = 7;
  reference.side_m = 0.12;
  world.references.push_back(reference);
  WriteWorld(folder_ / "world.toml", world);
  EXPECT_THAT(Refusal(kWorld), AllOf(StartsWith("a.toml:10: world.file"), HasSubstr("100 mm here"),
                                     HasSubstr("120 mm in the world file")));
  world.references[0].side_m = 0.1;
  WriteWorld(folder_ / "world.toml", world);
  EXPECT_EQ(Refusal(kWorld), "no error");
}

TEST_F(RobotConfig, ReadsLengthsWithUnits) {
  std::ofstream(folder_ / "robots.toml") << "[[robot]]\nname = \"alice\"\nid = 3\nposition = [\"2cm\", 0, \"105mm\"]\n";
  const FramePublisherOptions options =
      Parse(kWorld + "drift_limit = \"7mm\"\n" + kRobots + "max_height_error = \"5 cm\"\n").frames;
  EXPECT_EQ(options.drift.limit_m, 0.007);
  EXPECT_EQ(options.max_height_error_m, 0.05);
  const Eigen::Vector3d at = options.roster->robots.at(0).markers.at(0).body_from_marker.translation;
  EXPECT_EQ(at, Eigen::Vector3d(0.02, 0, 0.105));
}

TEST_F(RobotConfig, GivesTheDetectorTheSidesOfTheRoster) {
  std::ofstream(folder_ / "robots.toml") << "[[robot]]\nname = \"alice\"\nid = 3\nheight = 0.1\nside = [0.1, 0.102]\n";
  const DaemonConfig config = Parse(kRobots);
  EXPECT_EQ(config.detector.families.at(0).printed_by_id_m.at(3), Eigen::Vector2d(0.1, 0.102));
}

TEST_F(RobotConfig, ReadsEverything) {
  const FramePublisherOptions options =
      Parse(kWorld + "frames = \"both\"\ndrift_limit = 0.01\ndrift_window = 3.5\n" + kRobots +
            "ignore_others = true\nfloor = true\nmax_height_error = 0.05\nmax_tilt = 20\n[tracks]\nenabled = true\n"
            "time = \"publish\"\nmotion = \"turning\"\nacceleration = 2\nangular_acceleration = 90\ngate = 5\n"
            "coast = 1.5\nrefused_to_restart = 9\n")
          .frames;
  ASSERT_TRUE(options.world.has_value());
  EXPECT_EQ(options.world->world_from_camera.translation.z(), 3);
  EXPECT_EQ(options.frames, PublishedFrames::kBoth);
  EXPECT_EQ(options.drift.limit_m, 0.01);
  EXPECT_EQ(options.drift.window, milliseconds(3500));
  ASSERT_TRUE(options.roster.has_value());
  EXPECT_EQ(options.roster->robots.at(0).name, "alice");
  EXPECT_TRUE(options.ignore_others);
  EXPECT_TRUE(options.floor_mode);
  EXPECT_EQ(options.max_height_error_m, 0.05);
  EXPECT_NEAR(options.max_tilt_rad, 20 * std::numbers::pi / 180, 1e-12);
  EXPECT_TRUE(options.tracks);
  EXPECT_EQ(options.track_time, TrackTime::kPublish);
  EXPECT_EQ(options.tracker.model.motion, Motion::kTurning);
  EXPECT_EQ(options.tracker.model.acceleration_m_s2, 2);
  EXPECT_NEAR(options.tracker.model.angular_acceleration_rad_s2, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(options.tracker.gate, 5);
  EXPECT_EQ(options.tracker.coast, milliseconds(1500));
  EXPECT_EQ(options.tracker.refused_to_restart, 9);
}

TEST_F(RobotConfig, ShippedFileHoldsTheDefaults) {
  const FramePublisherOptions options =
      LoadDaemonConfig(std::filesystem::path(CHEQUER_TEST_DATA).parent_path() / "config/chequerd.toml").frames;
  const FramePublisherOptions defaults;
  EXPECT_FALSE(options.world.has_value());
  EXPECT_FALSE(options.roster.has_value());
  EXPECT_EQ(options.frames, defaults.frames);
  EXPECT_EQ(options.drift.limit_m, defaults.drift.limit_m);
  EXPECT_EQ(options.drift.window, defaults.drift.window);
  EXPECT_EQ(options.ignore_others, defaults.ignore_others);
  EXPECT_EQ(options.floor_mode, defaults.floor_mode);
  EXPECT_EQ(options.max_height_error_m, defaults.max_height_error_m);
  EXPECT_NEAR(options.max_tilt_rad, defaults.max_tilt_rad, 1e-12);
  EXPECT_EQ(options.tracks, defaults.tracks);
  EXPECT_EQ(options.track_time, defaults.track_time);
  EXPECT_EQ(options.tracker.model.motion, defaults.tracker.model.motion);
  EXPECT_EQ(options.tracker.model.acceleration_m_s2, defaults.tracker.model.acceleration_m_s2);
  EXPECT_NEAR(options.tracker.model.angular_acceleration_rad_s2, defaults.tracker.model.angular_acceleration_rad_s2,
              1e-12);
  EXPECT_EQ(options.tracker.gate, defaults.tracker.gate);
  EXPECT_EQ(options.tracker.coast, defaults.tracker.coast);
  EXPECT_EQ(options.tracker.refused_to_restart, defaults.tracker.refused_to_restart);
  EXPECT_EQ(TrackerOptions{}.Check(), "");
}

TEST_F(RobotConfig, RefusesWhatLacksWhatItNeeds) {
  EXPECT_THAT(Refusal(kWorld, false), AllOf(StartsWith("a.toml:10: world.file"), HasSubstr("camera.calibration")));
  EXPECT_THAT(Refusal(kRobots, false), AllOf(StartsWith("a.toml:10: robots.file"), HasSubstr("camera.calibration")));
  EXPECT_THAT(Refusal("[tracks]\nenabled = true\n", false), HasSubstr("camera.calibration"));
  EXPECT_THAT(Refusal("[world]\nframes = \"both\"\n"), AllOf(StartsWith("a.toml:10: "), HasSubstr("world.file")));
  EXPECT_THAT(Refusal(kRobots + "floor = true\n"), AllOf(StartsWith("a.toml:11: "), HasSubstr("needs world.file")));
  EXPECT_THAT(Refusal(kWorld + "[robots]\nfloor = true\n"), HasSubstr("needs robots.file"));
  EXPECT_THAT(Refusal("[robots]\nignore_others = true\n"), HasSubstr("needs robots.file"));
  EXPECT_EQ(Refusal("[world]\nframes = \"camera\"\n[tracks]\nenabled = true\n"), "no error");
}

TEST_F(RobotConfig, RefusesToPredictFramesOfAnotherTime) {
  const std::string old = "[tracks]\nenabled = true\ntime = \"publish\"\n";
  EXPECT_EQ(Refusal(old), "no error");
  std::string message;
  try {
    ParseDaemonConfig(
        "[camera]\ncalibration = \"camera.toml\"\n[capture]\npath = \"swarm\"\ntimes = \"recorded\"\n[[marker]]\n"
        "size = \"6x6\"\nvariant = \"secded\"\nside = 0.1\n" +
            old,
        "a.toml", folder_.path());
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  EXPECT_THAT(message, AllOf(StartsWith("a.toml:12: tracks.time"), HasSubstr("capture.times")));
}

TEST_F(RobotConfig, RefusesValuesOutOfRange) {
  EXPECT_THAT(Refusal(kWorld + "drift_limit = 0\n"), HasSubstr("0.0001 to 10"));
  EXPECT_THAT(Refusal(kWorld + "frames = \"floor\"\n"), HasSubstr("both"));
  EXPECT_THAT(Refusal(kRobots + "max_tilt = 200\n"), HasSubstr("1 to 180"));
  EXPECT_THAT(Refusal(kRobots + "max_height_error = -1\n"), HasSubstr("0.001 to 10"));
  EXPECT_THAT(Refusal("[tracks]\ngate = 1\n"), HasSubstr("2 to 100"));
  EXPECT_THAT(Refusal("[tracks]\ncoast = 100\n"), HasSubstr("0.01 to 60"));
  EXPECT_THAT(Refusal("[tracks]\nacceleration = 0\n"), HasSubstr("0.001 to 1000"));
  EXPECT_THAT(Refusal("[tracks]\nmotion = \"round\"\n"), HasSubstr("turning"));
}

TEST_F(RobotConfig, NamesTheFileAndTheLineThatIsWrongInIt) {
  EXPECT_THAT(Refusal("[world]\nfile = \"none.toml\"\n"),
              AllOf(StartsWith("a.toml:10: world.file"), HasSubstr("none.toml")));
  std::ofstream(folder_ / "bad.toml") << "[[robot]]\nname = \"alice\"\nid = -3\nheight = 0.1\n";
  EXPECT_THAT(Refusal("[robots]\nfile = \"bad.toml\"\n"),
              AllOf(StartsWith("a.toml:10: robots.file"), HasSubstr("bad.toml:3"), HasSubstr("id")));
  std::ofstream(folder_ / "bad.toml") << "[[robot]]\nname = \"alice\"\nid = 3\nheight = 0.1\nfamily = 1\n";
  EXPECT_THAT(Refusal("[robots]\nfile = \"bad.toml\"\n"), AllOf(HasSubstr("bad.toml:5"), HasSubstr("family")));
}

}  // namespace
}  // namespace chequer
