#include "daemon/logging.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "daemon/journal_sink.h"
#include "support/log_capture.h"

namespace chequer {
namespace {

class LoggingTest : public ::testing::Test {
 protected:
  ~LoggingTest() override {
    unsetenv("JOURNAL_STREAM");
    spdlog::set_default_logger(before_);
  }
  std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
};

TEST_F(LoggingTest, KnowsTheJournalByItsStream) {
  struct stat status {};
  ASSERT_EQ(fstat(STDERR_FILENO, &status), 0);
  const std::string device = std::to_string(status.st_dev) + ":";
  unsetenv("JOURNAL_STREAM");
  EXPECT_FALSE(StandardErrorIsJournal());
  setenv("JOURNAL_STREAM", (device + std::to_string(status.st_ino)).c_str(), 1);
  EXPECT_TRUE(StandardErrorIsJournal());
  // Inherited from a service, with standard error directed elsewhere.
  setenv("JOURNAL_STREAM", (device + std::to_string(status.st_ino + 1)).c_str(), 1);
  EXPECT_FALSE(StandardErrorIsJournal());
}

TEST_F(LoggingTest, LogsFromTheConfiguredLevelOn) {
  SetUpLogging({LogLevel::kWarning, LogTarget::kConsole}, "north", "1.0");
  EXPECT_FALSE(spdlog::should_log(spdlog::level::info));
  EXPECT_TRUE(spdlog::should_log(spdlog::level::warn));
  SetUpLogging({LogLevel::kDebug, LogTarget::kConsole}, "north", "1.0");
  EXPECT_TRUE(spdlog::should_log(spdlog::level::debug));
}

TEST_F(LoggingTest, LetsNoTextSpeakToTheTerminal) {
  SetUpLogging({LogLevel::kInfo, LogTarget::kConsole}, "north", "1.0");
  ::testing::internal::CaptureStderr();
  spdlog::info("camera {}", "evil\x1b[2J\u009b");
  spdlog::default_logger()->flush();
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), ::testing::EndsWith(" info camera evil?[2J?\n"));
}

TEST(Journal, RecordsSayWhoAndHowUrgent) {
  const LogField fields[] = {{"CHEQUER_CAMERA", "north"}, {"CHEQUER_EVENT", "camera_lost"}};
  EXPECT_THAT(
      JournalRecord(spdlog::level::err, "it is gone", "chq-capture", fields),
      ::testing::ElementsAre("MESSAGE=it is gone", "PRIORITY=3", "SYSLOG_IDENTIFIER=chequerd",
                             "CHEQUER_THREAD=chq-capture", "CHEQUER_CAMERA=north", "CHEQUER_EVENT=camera_lost"));
  EXPECT_EQ(JournalPriority(spdlog::level::critical), 2);
  EXPECT_EQ(JournalPriority(spdlog::level::warn), 4);
  EXPECT_EQ(JournalPriority(spdlog::level::info), 6);
  EXPECT_EQ(JournalPriority(spdlog::level::debug), 7);
}

TEST(LogEvent, IsAPlainMessageWhereThereIsNoJournal) {
  const test::LogCapture log;
  LogEvent(LogLevel::kWarning, "camera_lost", "it is {gone}");
  LogEvent(LogLevel::kDebug, "detail", "not shown");
  EXPECT_THAT(log.lines(), ::testing::ElementsAre("warning it is {gone}"));
}

}  // namespace
}  // namespace chequer
