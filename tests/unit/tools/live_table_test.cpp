#include "tools/live_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "unit/publish/messages.h"
#include "unit/tools/table_text.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::At;
using test::Lines;
using test::SamplePoses;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(LiveTable, ShowsPlaceRateAndAge) {
  LiveTable table;
  for (int i = 0; i <= 20; ++i) table.Add("C_POSES", SamplePoses(2), At(50 * i));
  const std::string text = table.Text(At(1500), 24);
  EXPECT_THAT(text, HasSubstr("C_POSES: 20.0 frames/s, 89 frames dropped"));
  // The last one came 0.5 s ago and was 6.5 ms old then.
  EXPECT_THAT(text, ContainsRegex(" 1 +0\\.2500 +-0\\.5000 +3\\.0000 +[-0-9.]+ +20\\.0 +0\\.51\n"));
  EXPECT_EQ(Lines(text), 4);
}

TEST(LiveTable, ForgetsMarkersAfterTenSeconds) {
  LiveTable table;
  table.Add("C", SamplePoses(3), At(0));
  EXPECT_EQ(Lines(table.Text(At(9000), 24)), 5);
  EXPECT_EQ(Lines(table.Text(At(10001), 24)), 2);
}

TEST(LiveTable, HasNoRateOfWhatDoesNotComeAnyMore) {
  LiveTable table;
  table.Add("C", SamplePoses(1), At(0));
  table.Add("C", SamplePoses(1), At(100));
  EXPECT_THAT(table.Text(At(3000), 24), HasSubstr("C: 0.0 frames/s"));
}

TEST(LiveTable, KeepsMarkersOfTwoCamerasApart) {
  LiveTable table;
  table.Add("A", SamplePoses(1), At(0));
  table.Add("B", SamplePoses(1), At(0));
  EXPECT_EQ(Lines(table.Text(At(0), 24)), 5);
}

TEST(LiveTable, FitsIntoTheTerminalAndSaysHowManyAreLeft) {
  LiveTable table;
  table.Add("C", SamplePoses(100), At(0));
  const std::string text = table.Text(At(0), 10);
  EXPECT_EQ(Lines(text), 10);
  EXPECT_THAT(text, HasSubstr("and 93 more\n"));
  EXPECT_EQ(Lines(table.Text(At(0), 102)), 102);
  EXPECT_THAT(table.Text(At(0), 102), Not(HasSubstr("more")));
}

TEST(LiveTable, HasNoBlankColumns) {
  LiveTable table;
  table.Add("C", SamplePoses(3), At(0));
  const std::string text = table.Text(At(0), 24);
  const std::string header = text.substr(text.find('\n') + 1);
  EXPECT_LE(header.find_first_not_of(' '), 3u);
  EXPECT_LE(header.find('\n'), 80u);
}

TEST(LiveTable, HoldsNoMoreThanItCanShow) {
  LiveTable table;
  PosesMessage message = SamplePoses(1);
  for (int i = 0; i < 20'000; ++i) {
    message.markers[0].id = static_cast<std::uint64_t>(i);
    table.Add("CHANNEL_" + std::to_string(i), message, At(0));
  }
  table.Add("MINE", SamplePoses(1), At(0));
  const std::string text = table.Text(At(0), 100'000);
  EXPECT_EQ(Lines(text), 64 + 1 + 4096);
  EXPECT_THAT(text, HasSubstr("MINE: "));
  EXPECT_THAT(text, HasSubstr("CHANNEL_19999: "));
  EXPECT_THAT(text, Not(HasSubstr("CHANNEL_1: "))) << "the oldest go";
}

TEST(LiveTable, LetsNoNameSpeakToTheTerminal) {
  LiveTable table;
  table.Add("A\x1b[2J\n\u009b\x9b_POSES", SamplePoses(0), At(0));
  EXPECT_THAT(table.Text(At(0), 24), HasSubstr("A?[2J???_POSES: "));
}

TEST(LiveTable, LeavesOutWhoseIdIsUndecided) {
  LiveTable table;
  PosesMessage message = SamplePoses(1);
  message.markers[0].id.reset();
  table.Add("C", message, At(0));
  EXPECT_EQ(Lines(table.Text(At(0), 24)), 2);
}

}  // namespace
}  // namespace chequer
