#include "robot/robot_roster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

#include "support/error_of.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::vector<MarkerFamily>& Families() {
  static const std::vector<MarkerFamily> families{
      {.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = 0.12, .roster = {}},
      {.code = MarkerCode({8, 8}, Variant::kGolay), .side_m = 0.2, .roster = {}}};
  return families;
}

RobotRoster Parse(const std::string& text) { return ParseRobotRoster(text, "robots.toml", Families()); }

std::string ErrorOf(const std::string& text) {
  return test::ErrorOf([&] { Parse(text); });
}

TEST(RobotRoster, ReadsARobotWithOneMarker) {
  const RobotRoster roster = Parse("[[robot]]\nname = \"alice\"\nid = 17\nheight = 0.12\n");
  ASSERT_EQ(roster.robots.size(), 1u);
  const RosterRobot& robot = roster.robots[0];
  EXPECT_EQ(robot.name, "alice");
  ASSERT_EQ(robot.markers.size(), 1u);
  EXPECT_EQ(robot.markers[0].id, 17u);
  EXPECT_EQ(robot.markers[0].family, 0);
  EXPECT_EQ(robot.markers[0].body_from_marker.translation, Eigen::Vector3d(0, 0, 0.12));
  EXPECT_LT(VectorFromRotation(robot.markers[0].body_from_marker.rotation).norm(), 1e-12);
  EXPECT_EQ(robot.body_height_m, 0) << "its origin is on the floor below the marker";
}

TEST(RobotRoster, ReadsWhereTheMarkerIsMounted) {
  const RobotRoster roster = Parse(
      "[[robot]]\nname = \"a\"\nid = 1\nheight = 0.3\nposition = [0.02, -0.01, 0.1]\nheading = 90\nfamily = 1\n"
      "[[robot]]\nname = \"b\"\nid = 2\nposition = [0, 0, 0.2]\norientation = [0, 1, 0, 0]\n");
  const RosterMarker& marker = roster.robots[0].markers[0];
  EXPECT_EQ(marker.family, 1);
  EXPECT_EQ(marker.body_from_marker.translation, Eigen::Vector3d(0.02, -0.01, 0.1));
  EXPECT_NEAR(VectorFromRotation(marker.body_from_marker.rotation).z(), std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(roster.robots[0].body_height_m, 0.2, 1e-12);
  EXPECT_EQ(roster.robots[1].body_height_m, 0);
  EXPECT_NEAR(roster.robots[1].markers[0].body_from_marker.rotation.x(), 1, 1e-12);
}

constexpr const char* kPair =
    "[[robot]]\nname = \"bob\"\nheight = 0.25\n"
    "[[robot.marker]]\nid = 3\nposition = [0.1, 0, 0.2]\n"
    "[[robot.marker]]\nid = 4\nposition = [-0.1, 0, 0.2]\nheading = 180\n";

TEST(RobotRoster, ReadsAPair) {
  const RobotRoster roster = Parse(kPair);
  ASSERT_EQ(roster.robots[0].markers.size(), 2u);
  EXPECT_EQ(roster.robots[0].markers[1].id, 4u);
  EXPECT_EQ(roster.robots[0].markers[1].body_from_marker.translation.x(), -0.1);
  EXPECT_NEAR(roster.robots[0].body_height_m, 0.05, 1e-12);
}

TEST(RobotRoster, ReadsTheSidesOfPrints) {
  std::vector<MarkerFamily> families = Families();
  families[0].printed_by_id_m[99] = {0.1, 0.1};  // of an earlier roster
  const RobotRoster roster = Parse(
      "[[robot]]\nname = \"a\"\nid = 1\nheight = 0.3\nside = [\"120.4mm\", 0.1198]\n"
      "[[robot]]\nname = \"b\"\n"
      "[[robot.marker]]\nid = 2\nposition = [0, 0, 0.2]\nside = \"100mm\"\nfamily = 1\n"
      "[[robot.marker]]\nid = 3\nposition = [0.1, 0, 0.2]\n");
  SetPrints(roster, families);
  ASSERT_EQ(families[0].printed_by_id_m.size(), 1u);
  EXPECT_TRUE(families[0].printed_by_id_m.at(1).isApprox(Eigen::Vector2d(0.1204, 0.1198)));
  EXPECT_TRUE(families[0].CellM(1).isApprox(Eigen::Vector2d(0.1204 / 6, 0.1198 / 6)));
  EXPECT_TRUE(families[0].CellM(3).isApprox(Eigen::Vector2d(0.02, 0.02))) << "as the others";
  EXPECT_TRUE(families[1].CellM(2).isApprox(Eigen::Vector2d(0.0125, 0.0125))) << "one length: square cells";
}

TEST(RobotRoster, RefusesSidesThatNoPrintHas) {
  const std::string alice = "[[robot]]\nname = \"alice\"\nid = 17\nheight = 0.12\n";
  EXPECT_THAT(ErrorOf(alice + "side = [0.12, 0.2]\n"), AllOf(StartsWith("robots.toml:5"), HasSubstr("side"),
                                                             HasSubstr("[width, height]"), HasSubstr("nearly square")));
  EXPECT_THAT(ErrorOf(alice + "side = 120\n"), AllOf(StartsWith("robots.toml:5"), HasSubstr("from 0.001 to 99")));
  EXPECT_THAT(ErrorOf(alice + "side = [0.12]\n"), AllOf(StartsWith("robots.toml:5"), HasSubstr("side")));
  EXPECT_THAT(ErrorOf(kPair + std::string("side = 0.1\n[[robot]]\nname = \"dave\"\n[[robot.marker]]\nid = 4\nposition "
                                          "= [0, 0, 0]\n[[robot.marker]]\nid = 5\nposition = [0.1, 0, 0]\n")),
              AllOf(HasSubstr("id 4 has another side"), HasSubstr("robots.toml:1")));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nside = 0.1\n[[robot.marker]]\nid = 1\nposition = [0, 0, 0]\n"
                      "[[robot.marker]]\nid = 2\nposition = [0, 0, 1]\n"),
              AllOf(StartsWith("robots.toml:3"), HasSubstr("belongs into [[robot.marker]]")));
}

TEST(RobotRoster, ErrorsNameFileLineAndKey) {
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = -1\nheight = 0.1\n"),
              AllOf(StartsWith("robots.toml:3"), HasSubstr("id")));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 1\nheight = 11\n"),
              AllOf(StartsWith("robots.toml:4"), HasSubstr("height"), HasSubstr("from 0 to 10")));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 1\nheight = 0.1\ncolour = \"red\"\n"),
              AllOf(StartsWith("robots.toml:5"), HasSubstr("colour")));
  EXPECT_THAT(ErrorOf("[[robot]]\nid = 1\nheight = 0.1\n"), AllOf(StartsWith("robots.toml:1"), HasSubstr("name")));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"\"\nid = 1\n"), StartsWith("robots.toml:2"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\\u0007\"\nid = 1\nheight = 1\n"), HasSubstr("control characters"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nheight = 0.1\n"), HasSubstr("id"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 1\n"), HasSubstr("height"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 1\nposition = [0, 0]\n"), HasSubstr("position"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 1\nposition = [0, 0, nan]\n"), HasSubstr("position"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 1\nheight = 1\norientation = [1, 1, 0, 0]\n"),
              HasSubstr("unit quaternion"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 1\nheight = 1\nheading = 3\norientation = [1, 0, 0, 0]\n"),
              HasSubstr("exclude each other"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 1\nheight = 1\nfamily = 2\n"),
              AllOf(StartsWith("robots.toml:5"), HasSubstr("below 2")));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 99999999\nheight = 1\n"),
              AllOf(StartsWith("robots.toml:3"), HasSubstr("largest id")));
  EXPECT_THAT(ErrorOf(""), HasSubstr("at least one [[robot]]"));
  EXPECT_THAT(ErrorOf("robot = 3"), StartsWith("robots.toml:1"));
}

TEST(RobotRoster, RefusesWhatDoesNotTellTwoRobotsApart) {
  const std::string alice = "[[robot]]\nname = \"alice\"\nid = 17\nheight = 0.12\n";
  EXPECT_THAT(ErrorOf(alice + alice), AllOf(StartsWith("robots.toml:6"), HasSubstr("stands twice")));
  EXPECT_THAT(ErrorOf(alice + "[[robot]]\nname = \"eve\"\nid = 17\nheight = 1\n"),
              AllOf(StartsWith("robots.toml:7"), HasSubstr("alice")));
  EXPECT_EQ(ErrorOf(alice + "[[robot]]\nname = \"eve\"\nid = 17\nfamily = 1\nheight = 1\n"), "no error");
  const std::string carol =
      "[[robot]]\nname = \"carol\"\n[[robot.marker]]\nid = 4\nposition = [0, 0, 0]\n"
      "[[robot.marker]]\nid = 3\nposition = [0.1, 0, 0]\n";
  EXPECT_THAT(ErrorOf(kPair + carol), HasSubstr("bob")) << "the same pair the other way round";
  const std::string dave =
      "[[robot]]\nname = \"dave\"\n[[robot.marker]]\nid = 4\nposition = [0, 0, 0]\n"
      "[[robot.marker]]\nid = 5\nposition = [0.1, 0, 0]\n";
  EXPECT_EQ(ErrorOf(kPair + dave), "no error") << "pairs may share an id";
  EXPECT_THAT(ErrorOf(kPair + std::string("[[robot]]\nname = \"x\"\nid = 4\nheight = 1\n")),
              HasSubstr("only robots with two markers may share"));
}

TEST(RobotRoster, RefusesHalfAPair) {
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\n[[robot.marker]]\nid = 1\nposition = [0, 0, 0]\n"),
              HasSubstr("two [[robot.marker]]"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\n[[robot.marker]]\nid = 1\nposition = [0, 0, 0]\n"
                      "[[robot.marker]]\nid = 1\nposition = [0, 0, 1]\n"),
              HasSubstr("two different ids"));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\nid = 3\n[[robot.marker]]\nid = 1\nposition = [0, 0, 0]\n"
                      "[[robot.marker]]\nid = 2\nposition = [0, 0, 1]\n"),
              AllOf(StartsWith("robots.toml:3"), HasSubstr("belongs into [[robot.marker]]")));
  EXPECT_THAT(ErrorOf("[[robot]]\nname = \"a\"\n[[robot.marker]]\nid = 1\n[[robot.marker]]\nid = 2\n"),
              AllOf(StartsWith("robots.toml:3"), HasSubstr("position")));
}

TEST(RobotRoster, IsReadBackAsItWasWritten) {
  const RobotRoster before = Parse(
      "[[robot]]\nname = \"a \\\"b\\\\\"\nid = 17\nheight = 0.3\nposition = [0.02, -0.01, 0.1]\nheading = 77.7\nfamily "
      "= 1\n"
      "[[robot]]\nname = \"c\"\nid = 5\nheight = 0.12\nside = [\"120.4mm\", 0.1198]\n" +
      std::string(kPair));
  const std::string text = FormatRobotRoster(before);
  const RobotRoster after = Parse(text);
  EXPECT_EQ(FormatRobotRoster(after), text);
  ASSERT_EQ(after.robots.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(after.robots[i].name, before.robots[i].name);
    EXPECT_NEAR(after.robots[i].body_height_m, before.robots[i].body_height_m, 1e-12);
    ASSERT_EQ(after.robots[i].markers.size(), before.robots[i].markers.size());
    for (std::size_t j = 0; j < after.robots[i].markers.size(); ++j) {
      const RosterMarker &read = after.robots[i].markers[j], &written = before.robots[i].markers[j];
      EXPECT_EQ(read.id, written.id);
      EXPECT_EQ(read.family, written.family);
      EXPECT_EQ(read.printed_m, written.printed_m);
      EXPECT_EQ(read.body_from_marker.translation, written.body_from_marker.translation);
      EXPECT_LT(read.body_from_marker.rotation.angularDistance(written.body_from_marker.rotation), 1e-12);
    }
  }
}

}  // namespace
}  // namespace chequer
