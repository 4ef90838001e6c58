#include "tools/live_robots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/publish/messages.h"
#include "unit/tools/table_text.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using test::At;
using test::Lines;
using test::SampleRobots;
using test::SampleTracks;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(LiveRobots, IsEmptyWhereNothingCame) {
  LiveRobots table;
  EXPECT_TRUE(table.empty());
  EXPECT_EQ(table.Text(At(0), 24), "");
}

TEST(LiveRobots, ShowsTracksWithSpeedYawRateAndAge) {
  LiveRobots table;
  table.Add("C_TRACKS", SampleTracks(2), At(0));
  const std::string text = table.Text(At(500), 24);
  EXPECT_EQ(Lines(text), 3);
  // Its last pose was 40 ms old when the track was published.
  EXPECT_THAT(text,
              ContainsRegex("robot 1 +0\\.2500 +-0\\.5000 +3\\.0000 +28\\.6 +0\\.573 +85\\.9 +0\\.54  coasting\n"));
}

TEST(LiveRobots, ATrackAndARobotOfOneNameAreOneLine) {
  LiveRobots table;
  table.Add("C_TRACKS", SampleTracks(1), At(0));
  table.Add("C_ROBOTS", SampleRobots(1), At(0));
  const std::string text = table.Text(At(0), 24);
  EXPECT_EQ(Lines(text), 2);
  EXPECT_THAT(text, HasSubstr("off the floor"));
  EXPECT_THAT(text, HasSubstr("0.573")) << "the track's";
  table.Add("D_ROBOTS", SampleRobots(1), At(0));
  EXPECT_EQ(Lines(table.Text(At(0), 24)), 3) << "another daemon's robot is another line";
}

TEST(LiveRobots, ShowsRobotsWithoutTracks) {
  LiveRobots table;
  table.Add("C_ROBOTS", SampleRobots(1), At(0));
  EXPECT_THAT(table.Text(At(0), 24), ContainsRegex("robot 0 +0\\.2500 +-0\\.5000 +3\\.0000 +[-0-9.]+ +- +- +0\\.01"));
}

TEST(LiveRobots, FitsEightyColumns) {
  LiveRobots table;
  table.Add("C_TRACKS", SampleTracks(20), At(0));
  const std::string text = table.Text(At(0), 24);
  const std::string header = text.substr(0, text.find('\n'));
  EXPECT_LE(header.size(), 80u);
  EXPECT_LE(header.find_first_not_of(' '), 4u) << "no blank columns";
}

TEST(LiveRobots, LetsNoNameSpeakToTheTerminalAndHoldsNoMoreThanItCanShow) {
  LiveRobots table;
  TracksMessage message = SampleTracks(1);
  for (int i = 0; i < 10'000; ++i) {
    message.tracks[0].key.robot = "evil\x1b[2J\u009b" + std::to_string(i);
    table.Add("C_TRACKS", message, At(0));
  }
  const std::string text = table.Text(At(0), 100'000);
  EXPECT_EQ(Lines(text), 1 + 4096);
  EXPECT_THAT(text, HasSubstr("evil?[2J?9999 "));
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
}

TEST(LiveRobots, ForgetsAfterTenSecondsAndFitsTheTerminal) {
  LiveRobots table;
  table.Add("C_TRACKS", SampleTracks(50), At(0));
  const std::string text = table.Text(At(0), 10);
  EXPECT_EQ(Lines(text), 10);
  EXPECT_THAT(text, HasSubstr("and 42 more\n"));
  EXPECT_THAT(table.Text(At(0), 51), Not(HasSubstr("more")));
  EXPECT_EQ(table.Text(At(10'001), 24), "");
}

}  // namespace
}  // namespace chequer
