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

CameraSetup SetupOf(const std::string& text) {
  const TemporaryDirectory directory;
  const fs::path file = directory / "north.toml";
  std::ofstream(file) << text;
  return LoadCameraSetup(file);
}

const std::string kMarker = "[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\n";

TEST(CameraSetup, ReadsWidthAndHeightOfAPrint) {
  const MarkerFamily family = SetupOf(kMarker + "side = [\"120.6mm\", 0.12]\n").families[0];
  EXPECT_LT((family.CellM() - Eigen::Vector2d(0.0201, 0.02)).norm(), 1e-12);
  EXPECT_NEAR(family.side_m, 0.1203, 1e-6) << "of square cells of the same area";
  const auto refusal = [](const std::string& side) {
    return ErrorOf([&] { SetupOf(kMarker + "side = " + side + "\n"); });
  };
  EXPECT_THAT(refusal("[0.12]"), HasSubstr("side"));
  EXPECT_THAT(refusal("[0.12, 0.2]"), HasSubstr("nearly square"));
}

TEST(CameraSetup, ReadsHowFarPrintsMayBeOff) {
  EXPECT_FALSE(SetupOf(kMarker).print_tolerance.any()) << "off unless given";
  EXPECT_EQ(SetupOf("[print]\ntolerance = \"office\"\n").print_tolerance, kOfficePrints);
  const PrintTolerance numbers =
      SetupOf("[print]\ntolerance = { scale = 0.004, register = \"0.1mm\" }\n").print_tolerance;
  EXPECT_EQ(numbers.scale, 0.004);
  EXPECT_DOUBLE_EQ(numbers.register_m, 1e-4);
  EXPECT_THAT(ErrorOf([] { SetupOf("[print]\ntolerance = \"offic\"\n"); }),
              AllOf(HasSubstr("north.toml:2"), HasSubstr("\"office\"")));
  EXPECT_THAT(ErrorOf([] { SetupOf("[print]\ntolerance = { scale = 1 }\n"); }), HasSubstr("0.05"));
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
