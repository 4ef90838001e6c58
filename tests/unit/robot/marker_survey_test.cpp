#include "robot/marker_survey.h"

#include <gtest/gtest.h>

#include <numbers>

#include "support/seed.h"
#include "unit/robot/measured_boards.h"

namespace chequer {
namespace {

using test::Detect;
using test::OnFloor;
using test::WorldFromCamera;

constexpr double kSurveyHeight = 0.137;

MarkerPose At(std::uint64_t id, double x, double height, std::mt19937_64* random = nullptr) {
  return Detect(id, WorldFromCamera().Inverse() * OnFloor(x, 0.1, 0.4, height), random);
}

TEST(MarkerSurvey, MeasuresHeightsWhileRobotsDrive) {
  std::mt19937_64 random = test::SeededGenerator();
  MarkerSurvey survey(WorldFromCamera());
  for (int i = 0; i < 60; ++i)
    survey.Add(std::vector{At(3, -0.5 + 0.01 * i, kSurveyHeight, &random), At(9, 0.4, 0.05)});
  const auto heights = survey.Heights();
  ASSERT_EQ(heights.size(), 2u);
  const MarkerHeight& height = heights.at({0, 3});
  EXPECT_NEAR(height.height_m, kSurveyHeight, 1e-3);
  EXPECT_GT(height.spread_m, 0);
  EXPECT_EQ(height.frames, 60);
  EXPECT_LT(height.tilt_rad, 0.02);
  EXPECT_NEAR(heights.at({0, 9}).height_m, 0.05, 1e-5);
}

TEST(MarkerSurvey, SomeBadPosesDoNotMatter) {
  MarkerSurvey survey(WorldFromCamera());
  for (int i = 0; i < 9; ++i) survey.Add(std::vector{At(3, 0.1, i % 3 == 0 ? 0.9 : kSurveyHeight)});
  MarkerPose undecided = At(4, 0, kSurveyHeight);
  undecided.id.reset();
  MarkerPose without_pose = At(5, 0, kSurveyHeight);
  without_pose.has_pose = false;
  survey.Add(std::vector{undecided, without_pose});
  const auto heights = survey.Heights();
  ASSERT_EQ(heights.size(), 1u);
  EXPECT_NEAR(heights.at({0, 3}).height_m, kSurveyHeight, 1e-5);
}

TEST(RosterOf, HasARobotForEachMarker) {
  const RobotRoster roster =
      RosterOf({{{0, 3}, {.height_m = 0.1, .frames = 5}}, {{1, 3}, {.height_m = 0.2, .frames = 5}}});
  ASSERT_EQ(roster.robots.size(), 2u);
  EXPECT_EQ(roster.robots[0].name, "robot_3");
  EXPECT_EQ(roster.robots[0].markers[0].body_from_marker.translation, Eigen::Vector3d(0, 0, 0.1));
  EXPECT_EQ(roster.robots[1].name, "robot_1_3");
  EXPECT_EQ(roster.robots[1].markers[0].family, 1);
}

TEST(WithHeights, ChangesTheHeightsAlone) {
  RobotRoster roster;
  RosterMarker marker{.id = 3, .family = 0, .body_from_marker = {RotationFromVector({0, 0, 1}), {0.1, 0.2, 0.3}}};
  RosterMarker unseen = marker;
  unseen.id = 4;
  roster.robots.push_back({.name = "alice", .markers = {marker, unseen}, .body_height_m = 0.05});
  const RobotRoster changed = WithHeights(roster, {{{0, 3}, {.height_m = 0.4, .frames = 1}}});
  EXPECT_EQ(changed.robots[0].name, "alice");
  EXPECT_EQ(changed.robots[0].markers[0].body_from_marker.translation, Eigen::Vector3d(0.1, 0.2, 0.4 - 0.05));
  EXPECT_EQ(changed.robots[0].markers[1].body_from_marker.translation, Eigen::Vector3d(0.1, 0.2, 0.3));
}

TEST(MarkerSurvey, NewcomersAreAddedToThoseThatHaveNames) {
  RobotRoster roster;
  roster.robots.push_back({.name = "alice", .markers = {{.id = 3, .family = 0, .body_from_marker = {}}}});
  roster.robots.push_back({.name = "robot_5", .markers = {{.id = 7, .family = 0, .body_from_marker = {}}}});
  AddNewcomers(roster, {{{0, 3}, {.height_m = 0.1, .frames = 5}}, {{0, 5}, {.height_m = 0.2, .frames = 5}}});
  ASSERT_EQ(roster.robots.size(), 3u);
  EXPECT_EQ(roster.robots[0].name, "alice");
  EXPECT_EQ(roster.robots[2].name, "robot_5_new") << "names stay different";
  EXPECT_EQ(roster.robots[2].markers[0].id, 5u);
}

}  // namespace
}  // namespace chequer
