#include "publish/lcm_publisher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "publish/lcm_log.h"
#include "publish/lcm_subscriber.h"
#include "support/file_size_limit.h"
#include "support/log_capture.h"
#include "support/stepped_clock.h"
#include "support/temporary_directory.h"
#include "unit/publish/messages.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::SamplePoses;
using test::SampleStatus;
using test::TemporaryDirectory;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string FileUrl(const std::filesystem::path& path) { return "file://" + path.string() + "?mode=w"; }

TEST(LcmPublisher, SendsOnTheChannelsOfItsPrefix) {
  const TemporaryDirectory folder;
  {
    LcmPublisher publisher({FileUrl(folder / "log"), "CHEQUER_ceiling"});
    EXPECT_TRUE(publisher.Publish(SamplePoses(3)));
    EXPECT_TRUE(publisher.Publish(SampleStatus()));
    EXPECT_EQ(publisher.health().state, PublisherState::kReady);
    EXPECT_EQ(publisher.health().sent, 2u);
    EXPECT_EQ(publisher.health().failed, 0u);
  }
  LcmLogReader log(folder / "log");
  const auto first = log.Next();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->channel, "CHEQUER_ceiling_POSES");
  EXPECT_EQ(std::get<PosesMessage>(first->message).markers.size(), 3u);
  const auto second = log.Next();
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(second->channel, "CHEQUER_ceiling_STATUS");
  EXPECT_EQ(std::get<StatusMessage>(second->message).version, "1.2.3");
  EXPECT_FALSE(log.Next().has_value());
  EXPECT_FALSE(log.damaged());
  EXPECT_EQ(log.skipped(), 0u);
}

TEST(LcmPublisher, TakesMessagesWithNobodyListening) {
  LcmPublisher publisher({"memq://", "CHEQUER"});
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(publisher.Publish(SamplePoses(1)));
  EXPECT_EQ(publisher.health().sent, 100u);
}

TEST(LcmPublisher, RefusesOptionsThatAreWrong) {
  EXPECT_THROW(LcmPublisher({"udp://", "CHEQUER"}), std::runtime_error);
  EXPECT_THROW(LcmPublisher({"memq://", "two words"}), std::runtime_error);
}

TEST(LcmPublisher, WaitsForWhatCannotBeOpenedAndComplainsOnce) {
  const TemporaryDirectory folder;
  const std::filesystem::path missing = folder / "missing";
  const std::string url = FileUrl(missing / "log");
  test::SteppedClock time;
  test::LogCapture log;
  LcmPublisher publisher({url, "CHEQUER"}, time.clock());
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(publisher.Publish(SamplePoses(1)));
    time.Advance(seconds(1));
  }
  EXPECT_EQ(publisher.health().state, PublisherState::kWaiting);
  EXPECT_THAT(publisher.health().message, HasSubstr(url));
  EXPECT_EQ(publisher.health().failed, 20u);
  ASSERT_EQ(log.lines().size(), 1u);
  EXPECT_THAT(log.lines()[0], HasSubstr("error LCM at " + url));

  std::filesystem::create_directory(missing);
  time.Advance(seconds(60));
  EXPECT_TRUE(publisher.Publish(SamplePoses(1)));
  EXPECT_EQ(publisher.health().state, PublisherState::kReady);
  EXPECT_THAT(publisher.health().message, IsEmpty());
  ASSERT_EQ(log.lines().size(), 2u);
  EXPECT_THAT(log.lines()[1], HasSubstr("works again; 20 messages were lost"));
}

TEST(LcmPublisher, NoticesAFullDisk) {
  test::LogCapture log;
  LcmPublisher publisher({"file:///dev/full?mode=w", "CHEQUER"});
  for (int i = 0; i < 500; ++i) EXPECT_FALSE(publisher.Publish(SamplePoses(20)));
  EXPECT_EQ(publisher.health().failed, 500u);
  EXPECT_EQ(publisher.health().state, PublisherState::kFailing);
  EXPECT_THAT(publisher.health().message, HasSubstr("No space left on device"));
  EXPECT_EQ(log.lines().size(), 1u);
}

TEST(LcmPublisher, AFullDiskIsComplainedOfOnceThoughSmallMessagesFit) {
  test::SteppedClock time;
  test::LogCapture log;
  const TemporaryDirectory folder;
  const test::FileSizeLimit limit(1000);
  LcmPublisher publisher({FileUrl(folder / "log"), "CHEQUER"}, time.clock());
  for (int i = 0; i < 500; ++i) {
    publisher.Publish(SamplePoses(20));
    publisher.Publish(SamplePoses(0));
    time.Advance(milliseconds(20));
  }
  EXPECT_GT(publisher.health().sent, 0u);
  EXPECT_GT(publisher.health().failed, 500u);
  EXPECT_EQ(log.lines().size(), 1u);
}

TEST(LcmPublisher, TriesAgainWithBackOffOnly) {
  const TemporaryDirectory folder;
  const std::filesystem::path missing = folder / "missing";
  test::SteppedClock time;
  test::LogCapture log;
  LcmPublisher publisher({FileUrl(missing / "log"), "CHEQUER"}, time.clock());
  EXPECT_FALSE(publisher.Publish(SamplePoses(1)));  // next try in 250 ms
  std::filesystem::create_directory(missing);
  time.Advance(milliseconds(249));
  EXPECT_FALSE(publisher.Publish(SamplePoses(1)));
  time.Advance(milliseconds(1));
  EXPECT_TRUE(publisher.Publish(SamplePoses(1)));
}

TEST(LcmLogReader, SaysWhenALogIsCutOff) {
  const TemporaryDirectory folder;
  {
    LcmPublisher publisher({FileUrl(folder / "log"), "CHEQUER"});
    publisher.Publish(SamplePoses(3));
    publisher.Publish(SamplePoses(3));
  }
  std::filesystem::resize_file(folder / "log", std::filesystem::file_size(folder / "log") - 10);
  LcmLogReader log(folder / "log");
  EXPECT_TRUE(log.Next().has_value());
  EXPECT_FALSE(log.Next().has_value());
  EXPECT_TRUE(log.damaged());
}

TEST(LcmLogReader, SaysThatOtherFilesAreNotLogs) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "text") << "not a log at all, but long enough to look for the beginning of an event in\n";
  LcmLogReader log(folder / "text");
  EXPECT_FALSE(log.Next().has_value());
  EXPECT_TRUE(log.damaged());
  EXPECT_THROW(LcmLogReader(folder / "missing"), std::runtime_error);
  EXPECT_THROW(LcmLogReader(folder.path()), std::runtime_error);
}

TEST(LcmSubscriber, ReceivesWhatALogHolds) {
  const TemporaryDirectory folder;
  {
    LcmPublisher publisher({FileUrl(folder / "log"), "CHEQUER"});
    LcmPublisher other({FileUrl(folder / "other"), "CHEQUER"});
    publisher.Publish(SamplePoses(2));
    publisher.Publish(SampleStatus());
  }
  int poses = 0;
  LcmSubscriber subscriber("file://" + (folder / "log").string() + "?speed=0", {"CHEQUER", ""},
                           [&](const std::string& channel, ReceivedMessage&& message) {
                             EXPECT_THAT(channel, HasSubstr("CHEQUER_"));
                             poses += std::holds_alternative<PosesMessage>(message) ? 1 : 0;
                           });
  int messages = 0;
  while (subscriber.Wait(seconds(10)) == LcmSubscriber::Outcome::kMessage) ++messages;
  EXPECT_EQ(messages, 2);
  EXPECT_EQ(poses, 1);
  EXPECT_EQ(subscriber.unreadable(), 0u);
}

/// LCM's own player writes beyond its memory where a log says 0x7fffffff bytes.
TEST(LcmSubscriber, SurvivesALogThatLies) {
  const TemporaryDirectory folder;
  {
    LcmPublisher publisher({FileUrl(folder / "log"), "CHEQUER"});
    for (int i = 0; i < 3; ++i) publisher.Publish(SamplePoses(2));
  }
  {
    std::fstream log(folder / "log", std::ios::in | std::ios::out | std::ios::binary);
    log.seekp(24).write("\x7f\xff\xff\xff", 4);
  }
  int messages = 0;
  LcmSubscriber subscriber("file://" + (folder / "log").string(), {"CHEQUER", ""},
                           [&](const std::string&, ReceivedMessage&&) { ++messages; });
  while (subscriber.Wait(seconds(10)) == LcmSubscriber::Outcome::kMessage) {
  }
  EXPECT_EQ(messages, 2);
  EXPECT_EQ(subscriber.unreadable(), 1u);
}

TEST(LcmSubscriber, PlaysALogAtItsPace) {
  const TemporaryDirectory folder;
  test::SteppedClock time;
  {
    LcmPublisher publisher({FileUrl(folder / "log"), "CHEQUER"}, time.clock());
    for (int i = 0; i < 2; ++i) {
      publisher.Publish(SamplePoses(1));
      time.Advance(std::chrono::hours(1));
    }
  }
  const std::string url = "file://" + (folder / "log").string();
  LcmSubscriber at_pace(url, {}, [](const std::string&, ReceivedMessage&&) {});
  EXPECT_EQ(at_pace.Wait(seconds(10)), LcmSubscriber::Outcome::kMessage);
  EXPECT_EQ(at_pace.Wait(milliseconds(1)), LcmSubscriber::Outcome::kTimeout) << "it is due in an hour";
  LcmSubscriber fast(url + "?speed=0", {}, [](const std::string&, ReceivedMessage&&) {});
  for (int i = 0; i < 2; ++i) EXPECT_EQ(fast.Wait(milliseconds(1)), LcmSubscriber::Outcome::kMessage);
  EXPECT_EQ(fast.Wait(milliseconds(1)), LcmSubscriber::Outcome::kClosed);
  LcmSubscriber none(url + "?speed=0", {"OTHER", ""}, [](const std::string&, ReceivedMessage&&) {});
  EXPECT_EQ(none.Wait(milliseconds(1)), LcmSubscriber::Outcome::kClosed);
}

TEST(LcmSubscriber, SaysWhatIsWrongWithItsUrl) {
  EXPECT_THROW(LcmSubscriber("nonsense", {}, {}), std::runtime_error);
  EXPECT_THROW(LcmSubscriber("file:///nowhere/log", {}, {}), std::runtime_error);
  EXPECT_THROW(LcmSubscriber("memq://", {"A", "B"}, {}), std::runtime_error);
}

}  // namespace
}  // namespace chequer
