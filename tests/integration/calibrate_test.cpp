// `chequer calibrate` as a whole program: photographs of a chessboard, frames of a camera, and what it says of bad
// input. tests/integration/room_test.cpp has the accuracy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "chequer/camera_file.h"
#include "support/process.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;
using test::Process;
using test::RunResult;
using test::RunToEnd;
using test::TemporaryDirectory;
using ::testing::HasSubstr;

const fs::path kData = fs::path(CHEQUER_TEST_DATA) / "data";

RunResult Calibrate(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {CHEQUER, "calibrate"});
  return RunToEnd(std::move(arguments));
}

void ExpectFails(const std::vector<std::string>& arguments, int status, const char* what) {
  const RunResult result = Calibrate(arguments);
  EXPECT_EQ(result.status, status) << result.output;
  EXPECT_THAT(result.output, HasSubstr(what));
}

TEST(CalibrateLensCommand, TakesPhotographsOfAChessboard) {
  const TemporaryDirectory directory;
  const fs::path out = directory.path() / "camera.toml";
  const RunResult result =
      Calibrate({"lens", "--chessboard", "9x6", "--square", "25mm", (kData / "chessboard").string(), "--out", out});
  ASSERT_EQ(result.status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("coverage"));
  EXPECT_THAT(result.output, HasSubstr("edges"));
  EXPECT_THAT(result.output, ::testing::AnyOf(HasSubstr("These views are enough"), HasSubstr("More views would")));
  const CameraModel camera = LoadCamera(out);
  EXPECT_NEAR(camera.fx, 535, 8);
  const auto record = LoadCalibrationRecord(out);
  ASSERT_TRUE(record.has_value());
  EXPECT_LT(record->rms_px, 0.3);
  EXPECT_GT(record->uncertainty[0], 0.1);
  EXPECT_TRUE(fs::exists(directory.path() / "camera.png"));
}

TEST(CalibrateLensCommand, TakesTheCameraOfAConfigurationAndKeepsWhatItDoesNotMeasure) {
  const TemporaryDirectory directory;
  const fs::path config = directory.path() / "chequerd.toml", out = directory.path() / "camera.toml";
  const CameraModel before{.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240, .rows_read_ms = 20};
  WriteCamera(out, before);
  std::ofstream(config) << "[camera]\nname = \"any\"\n[capture]\npath = \"" << (kData / "chessboard").string()
                        << "\"\npace = \"unlimited\"\n";
  const RunResult result = Calibrate({"lens", "--chessboard", "9x6", "--config", config, "--seconds", "50", "--out",
                                      out, "--picture", directory.path() / "picture.png", "--force"});
  ASSERT_EQ(result.status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("kept from the file before: rows_read_ms = 20"));
  EXPECT_EQ(LoadCamera(out).rows_read_ms, 20);
  EXPECT_NE(LoadCamera(out).fx, before.fx);
  EXPECT_TRUE(fs::exists(directory.path() / "picture.png"));
}

TEST(CalibrateLensCommand, DrawsCoverageOverItselfOnATerminal) {
  const TemporaryDirectory directory;
  const std::string config = directory.path() / "chequerd.toml", out = directory.path() / "camera.toml";
  std::ofstream(config) << "[capture]\npath = \"" << (kData / "chessboard").string() << "\"\npace = \"unlimited\"\n";
  Process process({"script", "-qec",
                   std::string(CHEQUER) + " calibrate lens --chessboard 9x6 --config " + config + " --out " + out,
                   "/dev/null"});
  EXPECT_EQ(process.Wait(std::chrono::seconds(60)), 0) << process.output();
  // Up by the lines of the picture and the one below it.
  EXPECT_THAT(process.output(), HasSubstr("\x1b[9A"));
  EXPECT_THAT(process.output(), HasSubstr("hold it into the"));
}

TEST(CalibrateLensCommand, SaysWhatIsWrongAndWritesNothing) {
  const TemporaryDirectory directory;
  const std::string out = directory.path() / "camera.toml", photos = kData / "chessboard", demo = kData / "demo_swarm";
  ExpectFails({"lens", photos, "--out", out}, 2, "--side");
  ExpectFails({"lens", "--side", "60mm", "--out", out}, 2, "--config FILE");
  ExpectFails({"lens", "--side", "60mm", photos, "--config", "x", "--out", out}, 1, "neither a file of that name");
  ExpectFails({"lens", "--chessboard", "9by6", photos, "--out", out}, 2, "9by6");
  ExpectFails({"lens", "--chessboard", "9x6", "--model", "pinhole", photos, "--out", out}, 2, "fisheye");
  ExpectFails({"lens", "--chessboard", "9x6", "--views", "3", photos, "--out", out}, 2, "--views");
  ExpectFails({"lens", "--chessboard", "9x6", photos, "--out", "camera.png"}, 2, "--picture");
  ExpectFails({"lens", "--chessboard", "9x6", photos, "--out", "/nowhere/camera.toml"}, 2, "/nowhere");
  ExpectFails({"lens", "--chessboard", "7x5", photos, "--out", out}, 1, "at least 4 are needed");
  ExpectFails({"lens", "--side", "60mm", "/nowhere", "--out", out}, 1, "/nowhere");
  ExpectFails({"lens", "--chessboard", "9x6", demo, "--out", out}, 1, "show chequer's markers, and no chessboard");
  ExpectFails({"lens", "--side", "60mm", "--marker", "8x8", "--variant", "golay", photos, "--out", out}, 1,
              "no marker of the sheet was seen");
  // Robots that drive are no sheet.
  ExpectFails({"lens", "--side", "12cm", demo, "--out", out}, 1, "sheet");
  EXPECT_FALSE(fs::exists(out));
}

TEST(CalibrateWorldCommand, SaysWhatIsWrongAndWritesNothing) {
  const TemporaryDirectory directory;
  const std::string out = directory.path() / "world.toml", demo = kData / "demo_swarm", camera = demo + "/camera.toml";
  const auto fails = [&](std::vector<std::string> arguments, int status, const char* what) {
    arguments.insert(arguments.begin(), {"world", "--side", "12cm", "--out", out});
    ExpectFails(arguments, status, what);
  };
  fails({"--calibration", camera, demo}, 2, "exactly one");
  fails({"--calibration", camera, "--origin", "1", "--l", "1,2,3", demo}, 2, "exactly one");
  fails({"--calibration", camera, "--l", "1,2", demo}, 2, "three different ids");
  fails({"--calibration", camera, "--l", "1,2,2", demo}, 2, "three different ids");
  fails({"--calibration", camera, "--origin", "one", demo}, 2, "id of a marker");
  fails({"--calibration", camera, "--origin", "999", demo}, 1, "marker 999 is not seen");
  fails({"--calibration", "/nowhere.toml", "--origin", "1", demo}, 1, "/nowhere.toml");
  ExpectFails({"world", "--side", "12cm", "--calibration", camera, "--origin", "1", demo, "--out", "/nowhere/w.toml"},
              2, "/nowhere");
  // Robots of the demo drive.
  fails({"--calibration", camera, "--origin", "0", demo}, 1, "moved by");
  const std::string list = directory.path() / "room.toml";
  std::ofstream(list) << "[[reference]]\nid = 0\nposition = [0, 0]\nheight = 3\n";
  fails({"--calibration", camera, "--references", list, demo}, 1, "room.toml:4: reference[0].height");
  std::ofstream(list) << "[[reference]]\nid = 0\nfamily = 1\nposition = [0, 0]\n";
  fails({"--calibration", camera, "--references", list, demo}, 1, "family = 1");
  std::ofstream(list) << "[[reference]]\nid = 900\nposition = [0, 0]\n";
  fails({"--calibration", camera, "--references", list, demo}, 1, "none of the 1 references is seen");
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace chequer
