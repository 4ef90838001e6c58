#include "tools/convert_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "capture/image_file.h"
#include "core/file.h"
#include "publish/lcm_publisher.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "tools/log_plot.h"
#include "unit/publish/messages.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

class ConvertLogTest : public ::testing::Test {
 protected:
  void SetUp() override {
    LcmPublisher publisher({"file://" + log_.string() + "?mode=w", "CHEQUER"});
    publisher.Publish(test::SamplePoses(2));
    publisher.Publish(test::SampleStatus());
  }

  std::vector<std::string> Lines(const std::string& name) const {
    std::ifstream file(folder_ / name);
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }

  test::TemporaryDirectory folder_;
  std::filesystem::path log_ = folder_ / "poses.lcm";
};

TEST_F(ConvertLogTest, KnowsALogByItsBeginning) {
  EXPECT_TRUE(IsLcmLog(log_));
  std::ofstream(folder_ / "text") << "no log";
  EXPECT_FALSE(IsLcmLog(folder_ / "text"));
  EXPECT_FALSE(IsLcmLog(folder_ / "missing"));
  EXPECT_FALSE(IsLcmLog(folder_.path()));
}

TEST_F(ConvertLogTest, WritesAnObjectALine) {
  ConvertLog(log_, (folder_ / "out.jsonl").string());
  const auto lines = Lines("out.jsonl");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(nlohmann::json::parse(lines[0])["markers"].size(), 2u);
  EXPECT_EQ(nlohmann::json::parse(lines[1])["type"], "status");
}

TEST_F(ConvertLogTest, WritesARowAMarker) {
  ConvertLog(log_, (folder_ / "out.csv").string());
  EXPECT_EQ(Lines("out.csv").size(), 3u);
}

TEST_F(ConvertLogTest, WritesTheStreamThatIsAskedFor) {
  {
    LcmPublisher publisher({"file://" + log_.string() + "?mode=a", "CHEQUER"});
    publisher.Publish(test::SampleRobots(2));
    publisher.Publish(test::SampleTracks(3));
  }
  ConvertLog(log_, (folder_ / "all.jsonl").string());
  EXPECT_EQ(Lines("all.jsonl").size(), 4u);
  ConvertLog(log_, (folder_ / "tracks.jsonl").string(), LogStream::kTracks);
  ASSERT_EQ(Lines("tracks.jsonl").size(), 1u);
  EXPECT_EQ(nlohmann::json::parse(Lines("tracks.jsonl")[0])["type"], "tracks");
  ConvertLog(log_, (folder_ / "robots.csv").string(), LogStream::kRobots);
  ASSERT_EQ(Lines("robots.csv").size(), 3u);
  EXPECT_THAT(Lines("robots.csv")[1], HasSubstr("CHEQUER_ROBOTS,ceiling,world,"));
  ConvertLog(log_, (folder_ / "tracks.csv").string(), LogStream::kTracks);
  EXPECT_EQ(Lines("tracks.csv").size(), 4u);
  ConvertLog(log_, (folder_ / "poses.csv").string());
  EXPECT_EQ(Lines("poses.csv").size(), 3u) << "a table holds the poses alone";
}

TEST_F(ConvertLogTest, SaysThatAStreamIsNotInTheLog) {
  try {
    ConvertLog(log_, (folder_ / "out.csv").string(), LogStream::kTracks);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no messages of that --stream, but 2 others"));
  }
}

std::string WhatIsWrong(const std::filesystem::path& log, const std::string& out) {
  try {
    ConvertLog(log, out);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST_F(ConvertLogTest, SaysWhatIsWrong) {
  const std::string out = (folder_ / "out.jsonl").string();
  EXPECT_THAT(WhatIsWrong(folder_ / "missing", out), HasSubstr("missing"));
  EXPECT_THAT(WhatIsWrong(log_, (folder_ / "none/out").string()), HasSubstr("none/out"));
  EXPECT_THAT(WhatIsWrong(log_, "/dev/full"), HasSubstr("/dev/full: cannot be written: No space"));
  std::filesystem::resize_file(log_, std::filesystem::file_size(log_) - 10);
  EXPECT_THAT(WhatIsWrong(log_, out), HasSubstr("cut off or damaged after 1 messages"));
  EXPECT_EQ(Lines("out.jsonl").size(), 1u);
  std::ofstream(folder_ / "empty");
  EXPECT_THAT(WhatIsWrong(log_, log_.string()), HasSubstr("is the log itself"));
  EXPECT_THAT(WhatIsWrong(folder_ / "empty", out), HasSubstr("no messages of chequer's"));
  EXPECT_EQ(Lines("out.jsonl").size(), 1u) << "what was there before is not lost to a log that holds nothing";
}

/// liblcm's own reader adds 1 to the length, which overflows, and writes beyond what it took.
TEST_F(ConvertLogTest, ALengthThatTheFileDoesNotHoldIsDamageAndTheRestIsRead) {
  std::string bytes = ReadFile(log_, 1 << 20);
  const std::string whole = bytes;
  for (const char* length : {"\x7f\xff\xff\xff", "\xff\xff\xff\xff", "\x80\x00\x00\x00", "\x10\x00\x00\x00"}) {
    bytes = whole + whole;
    bytes.replace(24, 4, std::string(length, 4));  // of the first event's data
    WriteFileAtomically(log_, bytes);
    EXPECT_THAT(WhatIsWrong(log_, (folder_ / "out.jsonl").string()), HasSubstr("damaged after 3 messages"));
    bytes = whole;
    bytes.replace(20, 4, std::string(length, 4));  // of its channel
    WriteFileAtomically(log_, bytes);
    EXPECT_THAT(WhatIsWrong(log_, (folder_ / "out.jsonl").string()), HasSubstr("damaged after 1 messages"));
  }
}

TEST_F(ConvertLogTest, DrawsWaysAndSpeedsOfTheBestStreamThereIs) {
  PlotLog(log_, folder_ / "poses.png", LogStream::kAll);
  const Image picture = LoadImage(folder_ / "poses.png");
  EXPECT_EQ(picture.width(), 1280);
  EXPECT_THAT(test::ErrorOf([&] { PlotLog(log_, folder_ / "none.png", LogStream::kTracks); }),
              HasSubstr("holds no poses"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.png"));
}

PosesMessage PosesAt(double time_s, double x, double y, const std::string& frame) {
  PosesMessage message;
  message.captured_monotonic = MonotonicTime(std::chrono::microseconds(std::llround(1e6 * time_s)));
  message.frame = frame;
  MarkerPose marker;
  marker.id = 7;
  marker.has_pose = true;
  marker.camera_from_marker.translation = {x, y, 3};
  message.markers.push_back(marker);
  return message;
}

TEST(MoveCollector, SpeedsArePosesOverTimeAndTheCamerasDownIsDown) {
  MoveCollector moves(LogStream::kPoses);
  moves.Add(PosesAt(10.0, 0.1, 0.2, "camera"));
  moves.Add(PosesAt(10.1, 0.1, 0.25, "camera"));
  const auto& way = moves.moves().at("id 7");
  ASSERT_EQ(way.size(), 2u);
  EXPECT_NEAR(way[1].time_s, 0.1, 1e-9);
  EXPECT_NEAR(way[1].speed_m_s, 0.5, 1e-9);
  EXPECT_NEAR(way[1].position_m.y(), -0.25, 1e-12);
  MoveCollector above(LogStream::kPoses);
  above.Add(PosesAt(0, 0.1, 0.2, "world"));
  EXPECT_NEAR(above.moves().at("id 7")[0].position_m.y(), 0.2, 1e-12);
}

}  // namespace
}  // namespace chequer
