#include "setup/camera_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>

#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using test::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(CameraSetup, NamesFilesBesideItThatNeedNotBeThere) {
  const TemporaryDirectory directory;
  const fs::path file = directory / "north.toml";
  std::ofstream(file) << "[camera]\nname = \"roof\"\ncalibration = \"camera.toml\"\n[world]\nfile = \"world.toml\"\n"
                         "drift_limit = 0.004\n[robots]\nfile = \"/elsewhere/robots.toml\"\n[detect]\n"
                         "color_space = \"hsv\"\n[capture]\nsource = \"v4l2\"\ndevice = \"/dev/video3\"\n"
                         "[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = \"12cm\"\nroster = [\"3-5\"]\n"
                         "[[marker]]\nsize = \"8x8\"\nvariant = \"golay\"\n";
  const CameraSetup setup = LoadCameraSetup(file);
  EXPECT_EQ(setup.file, file);
  EXPECT_EQ(setup.camera_name, "roof");
  EXPECT_EQ(setup.calibration, directory / "camera.toml");
  EXPECT_EQ(setup.world, directory / "world.toml");
  EXPECT_EQ(setup.robots, fs::path("/elsewhere/robots.toml"));
  EXPECT_EQ(setup.color_space, ColorSpace::kHsv);
  ASSERT_TRUE(setup.capture.has_value());
  EXPECT_EQ(setup.capture->source, SourceKind::kV4l2);
  ASSERT_EQ(setup.families.size(), 2u);
  EXPECT_DOUBLE_EQ(setup.families[0].side_m, 0.12);
  EXPECT_THAT(setup.families[0].roster, ElementsAre(3u, 4u, 5u));
  EXPECT_EQ(setup.families[1].side_m, 0);
}

TEST(CameraSetup, MayLeaveEverythingOut) {
  const TemporaryDirectory directory;
  const fs::path file = directory / "bare.toml";
  std::ofstream(file) << "[log]\nlevel = \"info\"\n";
  const CameraSetup setup = LoadCameraSetup(file);
  EXPECT_FALSE(setup.capture.has_value());
  EXPECT_FALSE(setup.calibration.has_value());
  EXPECT_TRUE(setup.families.empty());
}

TEST(CameraSetup, SaysWhatIsWrongWithItsPlace) {
  const TemporaryDirectory directory;
  const fs::path file = directory / "north.toml";
  std::ofstream(file) << "[[marker]]\nsize = \"6x6\"\nvariant = \"secdde\"\n";
  EXPECT_THAT(ErrorOf([&] { LoadCameraSetup(file); }), AllOf(HasSubstr("north.toml:3"), HasSubstr("secded")));
}

TEST(FindCameraSetup, LooksForNamesInTheFoldersInTurn) {
  const TemporaryDirectory first, second;
  std::ofstream(second / "north.toml") << "\n";
  std::ofstream(second / "south.toml") << "\n";
  std::ofstream(first / "south.toml") << "\n";
  const std::array<fs::path, 2> folders{first.path(), second.path()};
  EXPECT_EQ(FindCameraSetup("north", folders), second / "north.toml");
  EXPECT_EQ(FindCameraSetup("south", folders), first / "south.toml");
  EXPECT_EQ(FindCameraSetup("west/north", folders), fs::path("west/north"));
  EXPECT_EQ(FindCameraSetup("north.toml", folders), fs::path("north.toml"));
  EXPECT_THAT(ErrorOf([&] { FindCameraSetup("nroth", folders); }),
              AllOf(HasSubstr((first / "nroth.toml").string()), HasSubstr((second / "nroth.toml").string()),
                    HasSubstr("did you mean 'north'?")));
}

}  // namespace
}  // namespace chequer
