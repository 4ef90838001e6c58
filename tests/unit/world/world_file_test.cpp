#include "world/world_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "support/error_of.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kGood = R"([world]
position = [1.25, -0.5, 2.5]
orientation = [0.0, 1.0, 0.0, 0.0]

[[world.reference]]
id = 7
size = "6x6"
variant = "secded"
side = 0.12
position = [0.5, 0.25, 0.0]
orientation = [1, 0, 0, 0]
)";

std::string With(const std::string& old, const std::string& replacement) {
  std::string text = kGood;
  return text.replace(text.find(old), old.size(), replacement);
}

std::string ParsingErrorOf(const std::string& text) {
  return test::ErrorOf([&] { ParseWorld(text, "world.toml"); });
}

TEST(WorldFile, ReadsWhatItMustHold) {
  const WorldCalibration world = ParseWorld(kGood, "world.toml");
  EXPECT_EQ(world.world_from_camera.translation, Eigen::Vector3d(1.25, -0.5, 2.5));
  // The camera looks down: what it sees 2.5 m ahead lies on the floor.
  EXPECT_LT((world.world_from_camera * Eigen::Vector3d(0, 0, 2.5) - Eigen::Vector3d(1.25, -0.5, 0)).norm(), 1e-12);
  EXPECT_TRUE(world.covariance.isZero(0));
  EXPECT_FALSE(world.rms_m.has_value());
  ASSERT_EQ(world.references.size(), 1u);
  EXPECT_EQ(world.references[0].id, 7u);
  EXPECT_EQ(world.references[0].side_m, 0.12);
  EXPECT_EQ(world.references[0].world_from_marker.translation, Eigen::Vector3d(0.5, 0.25, 0));
}

TEST(WorldFile, GivesBackWhatWasWritten) {
  WorldCalibration world = ParseWorld(kGood, "world.toml");
  world.world_from_camera.rotation = RotationFromVector({2.1, 0.4, -0.3});
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) world.covariance(i, j) = (i == j ? 1e-6 : 1e-8) * (i + j + 1);
  world.rms_m = 0.00037;
  world.date = "2024-05-01T12:00:00Z";
  world.references[0].residual_m = {0.001, -0.002, 1.0 / 3};
  const WorldCalibration back = ParseWorld(FormatWorld(world), "world.toml");
  EXPECT_EQ(back.world_from_camera.translation, world.world_from_camera.translation);
  EXPECT_LT(back.world_from_camera.rotation.angularDistance(world.world_from_camera.rotation), 1e-12);
  EXPECT_EQ(back.covariance, world.covariance);
  EXPECT_EQ(back.rms_m, world.rms_m);
  EXPECT_EQ(back.date, world.date);
  ASSERT_EQ(back.references.size(), 1u);
  EXPECT_EQ(back.references[0].residual_m, world.references[0].residual_m);
  EXPECT_EQ(back.references[0].variant, Variant::kSecded);
}

TEST(WorldFile, NamesFileLineAndKeyOfWhatIsWrong) {
  EXPECT_THAT(ParsingErrorOf(With("position = [1.25, -0.5, 2.5]", "position = [1.25, -0.5]")),
              AllOf(HasSubstr("world.toml:2"), HasSubstr("world.position")));
  EXPECT_THAT(ParsingErrorOf(With("orientation = [0.0, 1.0, 0.0, 0.0]", "orientation = [0.5, 0.5, 0.5, 0.2]")),
              AllOf(HasSubstr("world.toml:3"), HasSubstr("world.orientation"), HasSubstr("unit quaternion")));
  EXPECT_THAT(ParsingErrorOf(With("orientation = [0.0, 1.0, 0.0, 0.0]", "")),
              AllOf(HasSubstr("world.orientation"), HasSubstr("is missing")));
  EXPECT_THAT(ParsingErrorOf(With("\"6x6\"", "\"6x600\"")),
              AllOf(HasSubstr("world.toml:7"), HasSubstr("reference[0].size")));
  EXPECT_THAT(ParsingErrorOf(With("\"secded\"", "\"sekded\"")),
              AllOf(HasSubstr("world.toml:8"), HasSubstr("variant"), HasSubstr("golay")));
  EXPECT_THAT(ParsingErrorOf(With("id = 7", "id = -7")), AllOf(HasSubstr("world.toml:6"), HasSubstr("id = -7")));
  EXPECT_THAT(ParsingErrorOf(With("side", "sight")), AllOf(HasSubstr("side"), HasSubstr("is missing")));
  EXPECT_THAT(ParsingErrorOf(std::string(kGood) + "colour = 1\n"),
              AllOf(HasSubstr("world.toml:12"), HasSubstr("unknown key")));
  EXPECT_THAT(ParsingErrorOf(With("[world]\n", "[world]\ndate = 'a \"date\"'\n")),
              AllOf(HasSubstr("world.toml:2"), HasSubstr("must be a date")));
  EXPECT_THAT(ParsingErrorOf(""), AllOf(HasSubstr("world"), HasSubstr("is missing")));
  EXPECT_THAT(ParsingErrorOf("[world"), HasSubstr("world.toml:1"));
}

}  // namespace
}  // namespace chequer
