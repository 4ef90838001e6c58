// One configuration supplies camera, markers, world and robots to every command; what is typed goes before it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "support/process.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;
using test::RunResult;
using test::RunToEnd;
using test::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const fs::path kChessboard = fs::path(CHEQUER_TEST_DATA) / "data/chessboard";

/// A folder in which commands are run as they are typed.
class Folder {
 public:
  fs::path operator/(const std::string& name) const { return folder_.path() / name; }
  /// `chequer COMMAND` with this as its folder.
  RunResult Run(const std::string& command) const {
    return RunToEnd({"/bin/sh", "-c", "cd '" + folder_.path().string() + "' && '" CHEQUER "' " + command});
  }
  /// Markers of 8x8 that stand still, and a configuration for them.
  void Render(const std::string& configuration) const {
    const RunResult rendered =
        Run("render --marker 8x8:golay:20cm --swarm 5 --speed 0 --frames 3 --size 1280x720 --out frames");
    ASSERT_EQ(rendered.status, 0) << rendered.output;
    std::ofstream(*this / configuration)
        << "[camera]\ncalibration = \"frames/camera.toml\"\n[capture]\npath = \"frames\"\npace = \"unlimited\"\n"
           "[[marker]]\nsize = \"8x8\"\nvariant = \"golay\"\nside = \"20cm\"\nroster = [\"0-49\"]\n"
           "[world]\nfile = \"world.toml\"\n[robots]\nfile = \"robots.toml\"\n";
  }

 private:
  TemporaryDirectory folder_;
};

TEST(OneConfiguration, IsEnoughForEveryCommand) {
  const Folder folder;
  folder.Render("north.toml");
  const RunResult detect = folder.Run("detect --config north frames/000000.png");
  EXPECT_EQ(detect.status, 0);
  EXPECT_THAT(detect.output, AllOf(HasSubstr("5 markers"), HasSubstr(" m "), Not(HasSubstr("looks like"))));
  EXPECT_THAT(folder.Run("explain --config north frames/000000.png").output, HasSubstr("5 markers"));
  std::ofstream(folder / "room.toml") << "[[reference]]\nid = 0\nposition = [0, 0]\nheading = 0\n"
                                         "[[reference]]\nid = 1\nposition = [99, 0]\n";
  const RunResult contradicted = folder.Run("calibrate world --config north room.toml");
  EXPECT_EQ(contradicted.status, 1);
  EXPECT_THAT(contradicted.output, HasSubstr("room.toml"));
  const RunResult world = folder.Run("calibrate world --config north --origin 0");
  EXPECT_EQ(world.status, 0) << world.output;
  EXPECT_THAT(world.output, HasSubstr("written: world.toml"));
  const RunResult robots = folder.Run("calibrate robots --config north");
  EXPECT_EQ(robots.status, 0) << robots.output;
  EXPECT_THAT(robots.output, HasSubstr("written: robots.toml"));
  const RunResult print = folder.Run("print --config north --paper A3 --out sheet.pdf");
  EXPECT_EQ(print.status, 0);
  EXPECT_THAT(print.output, HasSubstr("50 markers of 200 mm"));
  const RunResult snapshot = folder.Run("snapshot --config north --skip 0 --out now.png");
  EXPECT_EQ(snapshot.status, 0) << snapshot.output;
  EXPECT_EQ(RunToEnd({"/bin/sh", "-c", "cd '" + (folder / "").string() + "' && '" CHEQUERD "' --check --config north"})
                .status,
            0);
}

TEST(OneConfiguration, IsTakenFromTheFolderAndSaidToBe) {
  const Folder folder;
  folder.Render("chequer.toml");
  const RunResult detect = folder.Run("detect frames/000000.png");
  EXPECT_EQ(detect.status, 0);
  EXPECT_THAT(detect.output, AllOf(HasSubstr("chequer.toml supplies"), HasSubstr("5 markers")));
  ASSERT_EQ(folder.Run("calibrate world --origin 0").status, 0);
  ASSERT_EQ(folder.Run("calibrate robots").status, 0);
  EXPECT_EQ(RunToEnd({"/bin/sh", "-c", "cd '" + (folder / "").string() + "' && '" CHEQUERD "' --check"}).status, 0);
}

TEST(OneConfiguration, GivesWayToWhatIsTyped) {
  const Folder folder;
  folder.Render("north.toml");
  EXPECT_THAT(folder.Run("detect --config north --marker 6x6 --side 12cm frames/000000.png").output,
              HasSubstr("0 markers"));
  EXPECT_THAT(folder.Run("detect --config north --ids 0-1 frames/000000.png").output, HasSubstr("id_undecided"));
  const RunResult world = folder.Run("calibrate world --config north --origin 0 --out other.toml");
  EXPECT_EQ(world.status, 0) << world.output;
  EXPECT_TRUE(fs::exists(folder / "other.toml"));
  EXPECT_FALSE(fs::exists(folder / "world.toml"));
}

TEST(OneConfiguration, IsWhereTheLensIsWritten) {
  const Folder folder;
  std::ofstream(folder / "roof.toml") << "[camera]\ncalibration = \"lens.toml\"\n[capture]\npath = \""
                                      << kChessboard.string() << "\"\npace = \"unlimited\"\n[[marker]]\n"
                                      << "size = \"6x6\"\nvariant = \"secded\"\nside = \"12cm\"\n";
  // Before the lens is known, markers are found all the same.
  const RunResult before = folder.Run("detect --config roof '" + (kChessboard / "left01.jpg").string() + "'");
  EXPECT_THAT(before.output, HasSubstr("lens.toml is not there yet"));
  const RunResult lens = folder.Run("calibrate lens --config roof --chessboard 9x6");
  EXPECT_EQ(lens.status, 0) << lens.output;
  EXPECT_TRUE(fs::exists(folder / "lens.toml"));
  EXPECT_TRUE(fs::exists(folder / "lens.png"));
}

TEST(OneConfiguration, IsNamedWithWhatItLacks) {
  const Folder folder;
  std::ofstream(folder / "north.toml") << "[log]\nlevel = \"info\"\n";
  const RunResult no_such = folder.Run("calibrate world --config nroth --origin 0");
  EXPECT_EQ(no_such.status, 1);
  EXPECT_THAT(no_such.output, HasSubstr("did you mean 'north'?"));
  const RunResult no_file = folder.Run("calibrate world --config north --origin 0");
  EXPECT_EQ(no_file.status, 2);
  EXPECT_THAT(no_file.output, AllOf(HasSubstr("north.toml"), HasSubstr("calibration in [camera]")));
  const RunResult no_camera = folder.Run("calibrate lens --config north --side 6cm --out c.toml");
  EXPECT_EQ(no_camera.status, 1);
  EXPECT_THAT(no_camera.output, HasSubstr("[capture]"));
  EXPECT_EQ(folder.Run("print --config north --side 6cm --out s.pdf").status, 2);
}

TEST(DetectWithoutNames, NamesTheLikeliestKindOnStandardErrorAlone) {
  const Folder folder;
  folder.Render("north.toml");
  const std::string image = "frames/000000.png";
  EXPECT_THAT(folder.Run("detect " + image + " 2>&1 >/dev/null").output,
              AllOf(HasSubstr("8x8 golay (5 of 5 boards)"), HasSubstr("--marker 8x8:golay")));
  EXPECT_THAT(folder.Run("detect " + image + " 2>/dev/null").output, Not(HasSubstr("golay")));
  EXPECT_EQ(folder.Run("detect --json " + image + " 2>&1 >/dev/null").output, "");
  EXPECT_EQ(folder.Run("detect --marker 6x6 " + image + " 2>&1 >/dev/null").output, "");
  EXPECT_THAT(folder.Run("detect '" + (kChessboard / "left01.jpg").string() + "'").output,
              HasSubstr("shows no marker of any kind"));
}

}  // namespace
}  // namespace chequer
