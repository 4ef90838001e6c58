#include "tools/detect_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "chequer/camera_file.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(DetectOptions, TakeTheSidesOfTheConfigurationsRoster) {
  const test::TemporaryDirectory folder;
  WriteCamera(folder / "camera.toml", {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240});
  std::ofstream(folder / "north.toml") << "[camera]\ncalibration = \"camera.toml\"\n[[marker]]\nsize = \"6x6\"\n"
                                          "variant = \"secded\"\nside = 0.1\n[robots]\nfile = \"robots.toml\"\n";
  DetectOptions request;
  request.config = (folder / "north.toml").string();
  TakeSetup(request, "detect");
  EXPECT_TRUE(MakeDetectorOptions(request).families.at(0).printed_by_id_m.empty()) << "no roster yet";
  std::ofstream(folder / "robots.toml") << "[[robot]]\nname = \"a\"\nid = 3\nheight = 0.1\nside = [0.102, 0.1]\n";
  EXPECT_EQ(MakeDetectorOptions(request).families.at(0).printed_by_id_m.at(3), Eigen::Vector2d(0.102, 0.1));
  DetectOptions typed = request;
  typed.markers.side_m = 0.11;
  EXPECT_TRUE(MakeDetectorOptions(typed).families.at(0).printed_by_id_m.empty()) << "what is typed goes first";
  std::ofstream(folder / "robots.toml") << "[[robot]]\nname = \"a\"\nid = 3\nheight = 0.1\nside = [0.2, 0.1]\n";
  EXPECT_THAT(test::ErrorOf([&] { MakeDetectorOptions(request); }),
              AllOf(HasSubstr("robots.toml:5"), HasSubstr("side")));
}

}  // namespace
}  // namespace chequer
