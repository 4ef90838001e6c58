#include "tools/robot_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "unit/publish/messages.h"

namespace chequer {
namespace {

using nlohmann::json;
using test::SampleRobots;
using test::SampleTracks;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(RobotText, JsonTellsAllOfARobot) {
  const json line = json::parse(JsonLine("C_ROBOTS", SampleRobots(2)));
  EXPECT_EQ(line["type"], "robots");
  EXPECT_EQ(line["channel"], "C_ROBOTS");
  EXPECT_EQ(line["camera"], "ceiling");
  EXPECT_EQ(line["frame"], "world");
  EXPECT_EQ(line["sequence"], 1234567);
  EXPECT_EQ(line["captured_utc_us"], 1'700'000'000'123'456);
  ASSERT_EQ(line["robots"].size(), 2u);
  const json& robot = line["robots"][1];
  EXPECT_EQ(robot["name"], "robot 1");
  EXPECT_EQ(robot["marker_ids"], json({1, 101}));
  EXPECT_EQ(robot["position"], json({0.25, -0.5, 3.0}));
  EXPECT_EQ(robot["orientation"].size(), 4u);
  EXPECT_EQ(robot["covariance"].size(), 21u);
  const json& floor = robot["floor"];
  EXPECT_EQ(floor["position"], json({1.5, -2.5}));
  EXPECT_EQ(floor["heading"], 0.75);
  EXPECT_EQ(floor["covariance"], json({1.0, 2.0, 3.0, 4.0, 5.0, 6.0}));
  EXPECT_EQ(floor["height_error"], 0.125);
  EXPECT_EQ(floor["tilt"], 0.375);
  EXPECT_EQ(floor["chi_square"], 77.0);
  EXPECT_EQ(floor["off_floor"], true);
}

TEST(RobotText, JsonLeavesOutTheFloorWhereThereIsNone) {
  RobotsMessage message = SampleRobots(1);
  message.robots[0].floor.reset();
  message.robots[0].ambiguity = std::numeric_limits<double>::quiet_NaN();
  const json robot = json::parse(JsonLine("C", message))["robots"][0];
  EXPECT_FALSE(robot.contains("floor"));
  EXPECT_TRUE(robot["ambiguity"].is_null());
}

TEST(RobotText, JsonTellsAllOfATrack) {
  const json line = json::parse(JsonLine("C_TRACKS", SampleTracks(1)));
  EXPECT_EQ(line["type"], "tracks");
  EXPECT_EQ(line["valid_utc_us"], 1'700'000'000'131'000);
  EXPECT_EQ(line["valid_monotonic_us"], 42'007'545);
  const json& track = line["tracks"][0];
  EXPECT_EQ(track["name"], "robot 0");
  EXPECT_EQ(track["marker_id"], 0);
  EXPECT_EQ(track["family"], 2);
  EXPECT_NEAR(track["heading"].get<double>(), 0.5, 1e-12);
  EXPECT_EQ(track["velocity"], json({0.5, -0.25, 0.125}));
  EXPECT_EQ(track["angular_velocity"], json({0.0625, 0.03125, 1.5}));
  EXPECT_EQ(track["pose_covariance"].size(), 21u);
  EXPECT_EQ(track["velocity_covariance"].size(), 21u);
  EXPECT_EQ(track["age_us"], 5'000'000);
  EXPECT_EQ(track["since_seen_us"], 40'000);
  EXPECT_EQ(track["coasting"], true);
  EXPECT_EQ(track["poses_used"], 99);
  EXPECT_EQ(track["poses_refused"], 3);
}

TEST(RobotText, LinesForPeopleSayWhatIsToBeNoticed) {
  RobotsMessage robots = SampleRobots(2);
  robots.robots[0].floor->off_floor = false;
  const std::string line = PlainLine(robots);
  EXPECT_THAT(line, HasSubstr("ceiling frame 1234567: 2 robots"));
  EXPECT_THAT(line, HasSubstr("robot 0 (1.5000, -2.5000) m 42.97 deg  "));
  EXPECT_THAT(line, HasSubstr("robot 1 (0.2500, -0.5000, 3.0000) m"));
  EXPECT_THAT(line, HasSubstr("off the floor"));
  TracksMessage tracks = SampleTracks(1);
  EXPECT_THAT(PlainLine(tracks),
              HasSubstr("robot 0 (0.2500, -0.5000, 3.0000) m 28.65 deg 0.573 m/s 85.9 deg/s coasting"));
  tracks.tracks[0].coasting = false;
  tracks.tracks[0].key = {"", 0, 77};
  EXPECT_THAT(PlainLine(tracks), HasSubstr("1 track  77 ("));
  EXPECT_THAT(PlainLine(tracks), Not(HasSubstr("coasting")));
}

std::ptrdiff_t Commas(const std::string& line) { return std::count(line.begin(), line.end(), ','); }

TEST(RobotText, TablesHaveAsManyFieldsAsColumns) {
  RobotsMessage no_floor = SampleRobots(1);
  no_floor.robots[0].floor.reset();
  for (const RobotsMessage& message : {SampleRobots(1), SampleRobots(0), no_floor})
    EXPECT_EQ(Commas(CsvRows("C", message)), Commas(RobotsCsvHeader()));
  for (const TracksMessage& message : {SampleTracks(1), SampleTracks(0)})
    EXPECT_EQ(Commas(CsvRows("C", message)), Commas(TracksCsvHeader()));
  EXPECT_EQ(Commas(CsvRows("C", SampleTracks(3))), 3 * Commas(TracksCsvHeader()));
}

TEST(RobotText, TablesQuoteNames) {
  RobotsMessage message = SampleRobots(1);
  message.robots[0].name = "a, \"b\"";
  EXPECT_THAT(CsvRows("C", message), HasSubstr(",\"a, \"\"b\"\"\","));
  EXPECT_THAT(CsvRows("C", SampleTracks(1)), HasSubstr(",robot 0,0,0.25,-0.5,3,"));
}

}  // namespace
}  // namespace chequer
