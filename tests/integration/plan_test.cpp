// `chequer plan` as a whole program: what it says before anything is bought.
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

using test::RunResult;
using test::RunToEnd;
using test::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;

RunResult Plan(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {CHEQUER, "plan"});
  return RunToEnd(std::move(arguments));
}

TEST(PlanCommand, GivesVerdictErrorsCoverageAndAPicture) {
  const TemporaryDirectory folder;
  const std::string picture = folder / "plan.png";
  const RunResult plan =
      Plan({"--side", "40mm", "--distance", "3m", "--lens", "12mm", "--pixel", "3.45um", "--out", picture});
  EXPECT_EQ(plan.status, 0) << plan.output;
  EXPECT_THAT(plan.output, AllOf(HasSubstr("verdict   read: cells are 7.7 px wide, 1.9 times"),
                                 HasSubstr("error     x"), HasSubstr("Cramer-Rao"), HasSubstr("a side of 21 mm"),
                                 HasSubstr("1.66 x 0.93 m"), HasSubstr("at most 6.7 ms")));
  EXPECT_GT(std::filesystem::file_size(picture), 5000u);
}

TEST(PlanCommand, EndsWithAnotherStatusWhereNothingWillBeRead) {
  const RunResult plan = Plan({"--side", "8mm", "--distance", "3m", "--lens", "12mm", "--pixel", "3.45um"});
  EXPECT_EQ(plan.status, 3) << plan.output;
  EXPECT_THAT(plan.output, AllOf(HasSubstr("verdict   not read"), HasSubstr("a side of 21 mm")));
}

TEST(PlanCommand, TakesCameraAndMarkersOfAConfiguration) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "camera.toml")
      << "[camera]\nwidth = 1280\nheight = 720\nfx = 1000\nfy = 1000\ncx = 640\n"
         "cy = 360\nmodel = \"brown_conrady\"\ndistortion = [0.0, 0.0, 0.0, 0.0, 0.0]\n";
  std::ofstream(folder / "north.toml") << "[camera]\ncalibration = \"camera.toml\"\n[[marker]]\nsize = \"8x8\"\n"
                                          "variant = \"golay\"\nside = \"16cm\"\n";
  const RunResult plan = Plan({"--config", folder / "north.toml", "--distance", "2m"});
  EXPECT_EQ(plan.status, 0) << plan.output;
  EXPECT_THAT(plan.output, AllOf(HasSubstr("8x8 golay of 160 mm"), HasSubstr("cells are 10.0 px"), HasSubstr("1280")));
}

TEST(PlanCommand, SaysWhichCameraItAssumes) {
  EXPECT_THAT(Plan({"--help"}).output, HasSubstr("nothing is said has 1920 x 1080 pixels"));
  EXPECT_THAT(Plan({"--side", "40mm", "--distance", "1m"}).output,
              HasSubstr("1920 x 1080 pixels with a focal length of 1440 px"));
}

TEST(PlanCommand, SaysWhatIsMissing) {
  EXPECT_EQ(Plan({"--side", "40mm"}).status, 2);
  EXPECT_THAT(Plan({"--side", "40mm"}).output, HasSubstr("--distance"));
  EXPECT_THAT(Plan({"--distance", "3m"}).output, HasSubstr("--side"));
  EXPECT_THAT(Plan({"--side", "40mm", "--distance", "3m", "--lens", "12mm"}).output, HasSubstr("--pixel-pitch"));
  EXPECT_EQ(Plan({"--side", "40mm", "--distance", "3m", "--out", "plan.pdf"}).status, 2);
}

}  // namespace
}  // namespace chequer
