// Logs as the daemon writes and programs read them: what was written is never lost, and nothing is trusted.
#include "publish/lcm_log.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcm/eventlog.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "core/file.h"
#include "publish/lcm_log_events.h"
#include "publish/lcm_log_writer.h"
#include "publish/lcm_publisher.h"
#include "support/error_of.h"
#include "support/file_size_limit.h"
#include "support/temporary_directory.h"
#include "unit/publish/messages.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using test::SamplePoses;
using test::TemporaryDirectory;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

std::vector<std::uint8_t> Bytes(std::size_t count, std::uint8_t value = 7) {
  return std::vector<std::uint8_t>(count, value);
}

void Write(LcmLogWriter& log, std::size_t count, std::uint8_t value = 7) {
  EXPECT_EQ(log.Write(UtcTime(std::chrono::microseconds(123)), "CHANNEL", Bytes(count, value)), "");
}

/// The sizes of a log's messages.
std::vector<std::size_t> Sizes(const fs::path& path) {
  LogEventReader reader(path);
  std::vector<std::size_t> sizes;
  while (const auto event = reader.Next()) {
    EXPECT_EQ(event->channel, "CHANNEL");
    EXPECT_EQ(event->logged, UtcTime(std::chrono::microseconds(123)));
    sizes.push_back(event->data.size());
  }
  EXPECT_FALSE(reader.damaged());
  return sizes;
}

std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

using Counts = std::vector<std::size_t>;

TEST(LcmLogWriter, WritesWhatLcmReads) {
  const TemporaryDirectory folder;
  {
    LcmLogWriter log(folder / "log", EarlierLog::kSetAside);
    Write(log, 3, 5);
    Write(log, 100'000);
  }
  lcm_eventlog_t* read = lcm_eventlog_create((folder / "log").c_str(), "r");
  ASSERT_NE(read, nullptr);
  for (const int size : {3, 100'000}) {
    lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(read);
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->datalen, size);
    EXPECT_STREQ(event->channel, "CHANNEL");
    EXPECT_EQ(event->timestamp, 123);
    EXPECT_EQ(event->eventnum, size == 3 ? 0 : 1);
    EXPECT_EQ(static_cast<const std::uint8_t*>(event->data)[0], size == 3 ? 5 : 7);
    lcm_eventlog_free_event(event);
  }
  lcm_eventlog_destroy(read);
}

TEST(LcmLogWriter, AnEarlierLogIsRenamedWithItsTime) {
  const TemporaryDirectory folder;
  for (std::size_t i = 1; i <= 3; ++i) {
    LcmLogWriter log(folder / "poses.lcm", EarlierLog::kSetAside);
    EXPECT_EQ(log.set_aside().empty(), i == 1);
    Write(log, i);
    // All of one second.
    const timespec times[2]{{1'700'000'000, 0}, {1'700'000'000, 0}};
    ASSERT_EQ(utimensat(AT_FDCWD, (folder / "poses.lcm").c_str(), times, 0), 0);
  }
  EXPECT_EQ(Sizes(folder / "poses.lcm"), Counts{3});
  EXPECT_EQ(Sizes(folder / "poses-20231114T221320Z.lcm"), Counts{1});
  EXPECT_EQ(Sizes(folder / "poses-20231114T221320Z-2.lcm"), Counts{2});
  EXPECT_EQ(FilesIn(folder.path()).size(), 3u);
}

TEST(LcmLogWriter, AnEmptyFileNeedsNoOtherName) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "log");
  { LcmLogWriter log(folder / "log", EarlierLog::kSetAside); }
  EXPECT_EQ(FilesIn(folder.path()).size(), 1u);
}

TEST(LcmLogWriter, AppendsWhereItIsTold) {
  const TemporaryDirectory folder;
  for (std::size_t i = 1; i <= 3; ++i) {
    LcmLogWriter log(folder / "log", EarlierLog::kAppend);
    Write(log, i);
  }
  EXPECT_EQ(Sizes(folder / "log"), (Counts{1, 2, 3}));
}

TEST(LcmLogWriter, DoesNotAppendToWhatIsNoWholeLog) {
  const TemporaryDirectory folder;
  {
    LcmLogWriter log(folder / "cut", EarlierLog::kAppend);
    Write(log, 100);
    Write(log, 100);
  }
  fs::resize_file(folder / "cut", fs::file_size(folder / "cut") - 1);
  WriteFileAtomically(folder / "text", "what somebody wrote");
  for (const char* name : {"cut", "text"}) {
    LcmLogWriter log(folder / name, EarlierLog::kAppend);
    Write(log, 5);
    EXPECT_EQ(Sizes(folder / name), Counts{5});
    EXPECT_TRUE(fs::exists(log.set_aside()));
    if (std::string(name) == "text") {
      EXPECT_EQ(ReadFile(log.set_aside(), 100), "what somebody wrote");
    }
  }
}

TEST(LcmLogWriter, FollowsLinks) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "disk");
  fs::create_symlink("disk/log", folder / "link");
  for (int i = 0; i < 2; ++i) {
    LcmLogWriter log(folder / "link", EarlierLog::kSetAside);
    Write(log, 5);
  }
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(FilesIn(folder / "disk").size(), 2u);
}

TEST(LcmLogWriter, IsTheOnlyOne) {
  const TemporaryDirectory folder;
  for (const EarlierLog earlier : {EarlierLog::kSetAside, EarlierLog::kAppend}) {
    LcmLogWriter log(folder / "log", earlier);
    Write(log, 5);
    for (const EarlierLog other : {EarlierLog::kSetAside, EarlierLog::kAppend})
      EXPECT_THAT(ErrorOf([&] { LcmLogWriter(folder / "log", other); }), HasSubstr("another program writes it"));
    Write(log, 5);
    EXPECT_GE(Sizes(folder / "log").size(), 2u);
  }
}

TEST(LcmLogWriter, AFullDiskLosesWholeMessagesAlone) {
  const TemporaryDirectory folder;
  LcmLogWriter log(folder / "log", EarlierLog::kSetAside);
  std::size_t taken = 0;
  {
    const test::FileSizeLimit limit(10'000);
    for (std::size_t i = 0; i < 100; ++i) {
      const std::string why = log.Write(UtcTime(std::chrono::microseconds(123)), "CHANNEL", Bytes(900));
      taken += why.empty();
      EXPECT_TRUE(why.empty() || why == "File too large") << why;
    }
    EXPECT_EQ(taken, 10'000u / (28 + 7 + 900));
    EXPECT_EQ(Sizes(folder / "log").size(), taken) << "while the disk is full";
    Write(log, 1);  // still fits
  }
  Write(log, 900);
  EXPECT_EQ(Sizes(folder / "log").size(), taken + 2);
}

TEST(LcmLogWriter, WritesIntoDevicesAndPipes) {
  const TemporaryDirectory folder;
  { LcmLogWriter null("/dev/null", EarlierLog::kSetAside); }
  LcmLogWriter full("/dev/full", EarlierLog::kSetAside);
  EXPECT_THAT(full.Write({}, "CHANNEL", Bytes(1)), HasSubstr("No space"));
  struct stat status {};
  ASSERT_EQ(stat("/dev/full", &status), 0);
  EXPECT_TRUE(S_ISCHR(status.st_mode));
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(ErrorOf([&] { LcmLogWriter(folder / "pipe", EarlierLog::kAppend); }), HasSubstr("pipe"))
      << "nobody reads it";
  const UniqueFd reader(open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK));
  LcmLogWriter pipe(folder / "pipe", EarlierLog::kAppend);
  Write(pipe, 100);
  std::uint8_t bytes[200];
  EXPECT_EQ(read(reader.get(), bytes, sizeof bytes), 28 + 7 + 100);
}

TEST(LcmPublisher, TwoOfOneLogDoNotMixAndTheSecondSaysWhy) {
  const TemporaryDirectory folder;
  const std::string url = "file://" + (folder / "log").string() + "?mode=w";
  {
    LcmPublisher first({url, "FIRST"});
    EXPECT_TRUE(first.Publish(SamplePoses(1)));
    LcmPublisher second({url, "SECOND"});
    EXPECT_FALSE(second.Publish(SamplePoses(1)));
    EXPECT_THAT(second.health().message, HasSubstr("another program writes it"));
    EXPECT_TRUE(first.Publish(SamplePoses(1)));
  }
  LcmLogReader log(folder / "log");
  for (int i = 0; i < 2; ++i) EXPECT_EQ(log.Next()->channel, "FIRST_POSES");
  EXPECT_FALSE(log.Next().has_value());
  EXPECT_FALSE(log.damaged());
}

/// As a reload does that changes the prefix alone: the next publisher is made while the one before still writes.
TEST(LcmPublisher, TheNextOneOfALogBeginsWhenTheOneBeforeIsGone) {
  const TemporaryDirectory folder;
  const std::string url = "file://" + (folder / "log").string() + "?mode=w";
  auto first = std::make_unique<LcmPublisher>(LcmPublisherOptions{url, "FIRST"});
  EXPECT_TRUE(first->Publish(SamplePoses(1)));
  LcmPublisher second({url, "SECOND"});
  EXPECT_TRUE(first->Publish(SamplePoses(1)));
  first.reset();
  EXPECT_TRUE(second.Publish(SamplePoses(1)));
  EXPECT_EQ(LcmLogReader(folder / "log").Next()->channel, "SECOND_POSES");
  const std::vector<fs::path> files = FilesIn(folder.path());
  ASSERT_EQ(files.size(), 2u);
  EXPECT_THAT(files[1].filename().string(), MatchesRegex("log-[0-9]*T[0-9]*Z"));
  LcmLogReader before(files[1]);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(before.Next()->channel, "FIRST_POSES");
  EXPECT_FALSE(before.damaged());
}

TEST(LogEventReader, GoesOnAfterWhatIsDamaged) {
  const TemporaryDirectory folder;
  {
    LcmLogWriter log(folder / "log", EarlierLog::kSetAside);
    for (std::size_t i = 0; i < 3; ++i) Write(log, 10 + i);
  }
  const std::string whole = ReadFile(folder / "log", 1000);
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const char damage : {'\0', '\x7f', '\x80', '\xff'}) {
      std::string bytes = whole;
      bytes[at] = damage;
      WriteFileAtomically(folder / "damaged", bytes, Durability::kUnsynced);
      LogEventReader reader(folder / "damaged");
      int events = 0;
      while (reader.Next()) ++events;
      EXPECT_GE(events, 2) << at;
      EXPECT_LE(events, 3) << at;
    }
}

TEST(LogEventReader, DoesNotWaitForAPipe) {
  const TemporaryDirectory folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(ErrorOf([&] { LogEventReader(folder / "pipe"); }), HasSubstr("is a pipe, not a file"));
}

}  // namespace
}  // namespace chequer
