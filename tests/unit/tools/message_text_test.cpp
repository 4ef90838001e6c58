#include "tools/message_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>
#include <sstream>

#include "core/printable.h"
#include "tools/robot_text.h"
#include "unit/publish/messages.h"

namespace chequer {
namespace {

using nlohmann::json;
using test::SamplePoses;
using test::SampleStatus;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(HeadingDegrees, IsTheDirectionOfTheMarkersXAxis) {
  MarkerPose marker;
  marker.has_pose = true;
  EXPECT_NEAR(HeadingDegrees(marker), 0, 1e-9);
  // A marker that faces the camera is turned about x by half a turn; its x axis stays.
  const Eigen::Quaterniond facing = RotationFromVector({std::numbers::pi, 0, 0});
  for (const double degrees : {-170.0, -90.0, 30.0, 179.0}) {
    marker.camera_from_marker.rotation = RotationFromVector({0, 0, degrees * std::numbers::pi / 180}) * facing;
    EXPECT_NEAR(HeadingDegrees(marker), degrees, 1e-9);
  }
}

TEST(JsonLine, TellsAllOfAFrame) {
  const json line = json::parse(JsonLine("C_POSES", SamplePoses(2)));
  EXPECT_EQ(line["type"], "poses");
  EXPECT_EQ(line["channel"], "C_POSES");
  EXPECT_EQ(line["camera"], "ceiling");
  EXPECT_EQ(line["frame"], "camera");
  EXPECT_EQ(line["sequence"], 1234567);
  EXPECT_EQ(line["captured_utc_us"], 1'700'000'000'123'456);
  EXPECT_EQ(line["captured_monotonic_us"], 42'000'001);
  EXPECT_EQ(line["instant"], "middle");
  EXPECT_EQ(line["published_utc_us"], 1'700'000'000'130'000);
  EXPECT_EQ(line["published_monotonic_us"], 42'006'545);
  EXPECT_EQ(line["frames_dropped"], 89);
  EXPECT_EQ(line["width"], 1920);
  EXPECT_EQ(line["height"], 1080);
  ASSERT_EQ(line["markers"].size(), 2u);
}

TEST(JsonLine, SaysOfWhatANewerVersionSentThatItIsUnknown) {
  PosesMessage poses = SamplePoses(1);
  poses.instant = static_cast<ExposureInstant>(200);
  poses.markers[0].variant = static_cast<Variant>(200);
  const json line = json::parse(JsonLine("C_POSES", poses));
  EXPECT_EQ(line["instant"], "unknown");
  EXPECT_EQ(line["markers"][0]["variant"], "unknown");
  StatusMessage status = SampleStatus();
  status.camera_state = static_cast<CameraState>(200);
  status.publisher.state = static_cast<PublisherState>(200);
  const json state = json::parse(JsonLine("C_STATUS", status));
  EXPECT_EQ(state["camera_state"], "unknown");
  EXPECT_EQ(state["publisher_state"], "unknown");
}

TEST(JsonLine, TellsAllOfAMarker) {
  const json marker = json::parse(JsonLine("C", SamplePoses(2)))["markers"][1];
  EXPECT_EQ(marker["id"], 1);
  EXPECT_EQ(marker["variant"], "golay");
  EXPECT_EQ(marker["size"], "8x7");
  EXPECT_EQ(marker["family"], 3);
  EXPECT_EQ(marker["position"], json({0.25, -0.5, 3.0}));
  EXPECT_EQ(marker["orientation"].size(), 4u);
  EXPECT_EQ(marker["covariance"].size(), 21u);
  EXPECT_NEAR(marker["covariance"][20], 36e-9, 1e-12);
  EXPECT_EQ(marker["ambiguity"], 0.125);
  EXPECT_EQ(marker["center_px"], json({320.5, 240.25}));
  EXPECT_EQ(marker["corners_used"], 41);
  EXPECT_EQ(marker["reprojection_rms_px"], 0.0625);
  EXPECT_EQ(marker["luminance_overlap"], 0.03125);
  EXPECT_EQ(marker["saturation_overlap"], 0.015625);
  EXPECT_EQ(marker["bits_corrected"], 2);
  EXPECT_EQ(marker["warnings"], json({"partly_hidden", "ambiguous_pose"}));
}

TEST(JsonLine, LeavesOutWhatIsNotKnown) {
  PosesMessage message = SamplePoses(1);
  message.markers[0].id.reset();
  message.markers[0].has_pose = false;
  const json marker = json::parse(JsonLine("C", message))["markers"][0];
  EXPECT_TRUE(marker["id"].is_null());
  EXPECT_FALSE(marker.contains("position"));
  EXPECT_FALSE(marker.contains("covariance"));
}

TEST(JsonLine, KeepsLargeIdsAndIsOneLine) {
  PosesMessage message = SamplePoses(1);
  message.markers[0].id = std::numeric_limits<std::uint64_t>::max();
  message.camera = "two\nlines \xff";
  const std::string line = JsonLine("C", message);
  EXPECT_THAT(line, Not(HasSubstr("\n")));
  EXPECT_EQ(json::parse(line)["markers"][0]["id"], std::numeric_limits<std::uint64_t>::max());
}

/// What comes from the network must not speak to the terminal, in no form.
TEST(Lines, HoldNothingThatATerminalObeys) {
  const std::string evil = "\x1b]0;owned\a\n\u009b2J\x9b\x7f";
  PosesMessage poses = SamplePoses(1);
  poses.camera = poses.frame = evil;
  StatusMessage status = SampleStatus();
  status.camera = status.version = status.camera_source = status.camera_message = status.publisher.message = evil;
  status.drops = status.detections = {{evil, 1}};
  status.stages = {{evil, 1, {}, {}, {}}, {"total", 1, {}, {}, {}}};
  RobotsMessage robots = test::SampleRobots(1);
  robots.header.camera = robots.header.frame = robots.robots[0].name = evil;
  TracksMessage tracks = test::SampleTracks(1);
  tracks.header.camera = tracks.header.frame = tracks.tracks[0].key.robot = evil;
  for (const std::string& line :
       {PlainLine(poses), PlainLine(status), PlainLine(robots), PlainLine(tracks), JsonLine(evil, poses),
        JsonLine(evil, status), JsonLine(evil, robots), JsonLine(evil, tracks), CsvField(evil)}) {
    EXPECT_EQ(Printable(line.substr(0, 900)), line.substr(0, 900));
    EXPECT_EQ(PrintableLines(line), line);
    EXPECT_THAT(line, Not(HasSubstr("\n")));
  }
  EXPECT_EQ(json::parse(JsonLine("C", poses))["camera"], "\x1b]0;owned\a\n\u009b2J\ufffd\x7f")
      << "programs lose nothing";
}

TEST(JsonLine, TellsAllOfTheStatus) {
  const json line = json::parse(JsonLine("C_STATUS", SampleStatus()));
  EXPECT_EQ(line["type"], "status");
  EXPECT_EQ(line["version"], "1.2.3");
  EXPECT_EQ(line["camera_state"], "ended");
  EXPECT_EQ(line["publisher_state"], "failing");
  EXPECT_EQ(line["messages_failed"], 12);
  EXPECT_EQ(line["drops"]["superseded"], 3);
  EXPECT_EQ(line["stages"]["detect"]["p99_us"], 7000);
  EXPECT_EQ(line["detections"]["boards"], 3000);
  EXPECT_EQ(line.size(), 29u);  // 28 fields of the status and the channel; the type included
}

TEST(PlainLine, NamesMarkersAndPlaces) {
  EXPECT_THAT(PlainLine(SamplePoses(1)), HasSubstr("ceiling frame 1234567: 1 marker  0 (0.250, -0.500, 3.000) m"));
  PosesMessage message = SamplePoses(1);
  message.markers[0].id.reset();
  message.markers[0].has_pose = false;
  EXPECT_THAT(PlainLine(message), HasSubstr("? (320.5, 240.2) px"));
}

TEST(FixedText, HasNoSignWhereItRoundsToZero) {
  EXPECT_EQ(FixedText(-0.0, 1), "0.0");
  EXPECT_EQ(FixedText(-0.00004, 4), "0.0000");
  EXPECT_EQ(FixedText(-0.0, 0), "0");
  EXPECT_EQ(FixedText(-0.00006, 4), "-0.0001");
  EXPECT_EQ(FixedText(-10.0, 0), "-10");
  EXPECT_EQ(FixedText(std::numeric_limits<double>::infinity(), 2), "inf");
}

/// "-0" that no digit but zeros follows: in no form does a line have it.
constexpr const char* kMinusZero = "(^|[^0-9e])-0(\\.0*)?([^0-9.]|$)";

TEST(Lines, HaveNoMinusBeforeAZero) {
  PosesMessage poses = SamplePoses(1);
  MarkerPose& marker = poses.markers[0];
  // Turned by nothing, or by less than is printed, the other way round.
  marker.camera_from_marker = {Eigen::Quaterniond(1, -0.0, 0, -1e-9), {-0.0, -1e-7, 2}};
  marker.covariance(0, 1) = -0.0;
  RobotsMessage robots = test::SampleRobots(1);
  robots.robots[0].frame_from_body = marker.camera_from_marker;
  robots.robots[0].floor->position = {-0.0, -1e-9};
  robots.robots[0].floor->heading_rad = robots.robots[0].floor->tilt_rad = -0.0;
  robots.robots[0].floor->off_floor = false;
  TracksMessage tracks = test::SampleTracks(1);
  tracks.tracks[0].frame_from_body = marker.camera_from_marker;
  tracks.tracks[0].velocity.setConstant(-0.0);
  tracks.tracks[0].angular_velocity.setConstant(-0.0);
  for (const std::string& line :
       {PlainLine(poses), PlainLine(robots), PlainLine(tracks), JsonLine("C", poses), JsonLine("C", robots),
        JsonLine("C", tracks), CsvRows("C", poses), CsvRows("C", robots), CsvRows("C", tracks)})
    EXPECT_FALSE(std::regex_search(line, std::regex(kMinusZero))) << line;
}

TEST(PlainLine, NamesTheTrouble) {
  const std::string line = PlainLine(SampleStatus());
  EXPECT_THAT(line, HasSubstr("camera ended, 59.5 frames/s"));
  EXPECT_THAT(line, HasSubstr("; over; no route"));
}

int Columns(const std::string& line) { return 1 + static_cast<int>(std::count(line.begin(), line.end(), ',')); }

TEST(Csv, HasTheColumnsOfItsHeaderInEveryRow) {
  const int columns = Columns(CsvHeader());
  PosesMessage message = SamplePoses(3);
  message.markers[1].id.reset();
  message.markers[2].has_pose = false;
  std::istringstream rows(CsvRows("C", message));
  int count = 0;
  for (std::string row; std::getline(rows, row); ++count) EXPECT_EQ(Columns(row), columns) << row;
  EXPECT_EQ(count, 3);
  const std::string empty = CsvRows("C", SamplePoses(0));
  EXPECT_EQ(Columns(empty), columns);
  EXPECT_THAT(empty, ::testing::StartsWith("C,ceiling,1234567,"));
}

TEST(Csv, QuotesNamesThatHoldSeparators) {
  PosesMessage message = SamplePoses(0);
  message.camera = "a,\"b\"";
  EXPECT_THAT(CsvRows("C", message), ::testing::StartsWith("C,\"a,\"\"b\"\"\","));
}

}  // namespace
}  // namespace chequer
