#include "daemon/logging.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "core/unique_fd.h"
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

/// Standard error leads into a pipe that holds a page, while it lives.
class PipeAsStandardError {
 public:
  PipeAsStandardError() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    reader_ = UniqueFd(ends[0]);
    const UniqueFd writer(ends[1]);
    ::fcntl(writer.get(), F_SETPIPE_SZ, 4096);
    ::fcntl(reader_.get(), F_SETFL, O_NONBLOCK);
    ::dup2(writer.get(), STDERR_FILENO);
  }
  ~PipeAsStandardError() { ::dup2(before_.get(), STDERR_FILENO); }

  std::string Read() {
    std::string text(1 << 20, ' ');
    const ssize_t count = ::read(reader_.get(), text.data(), text.size());
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    return text;
  }

 private:
  UniqueFd before_{::dup(STDERR_FILENO)};
  UniqueFd reader_;
};

// Where one of these waits, the test never ends.
TEST_F(LoggingTest, DoesNotWaitForWhoReadsIt) {
  PipeAsStandardError console;
  SetUpLogging({LogLevel::kInfo, LogTarget::kConsole}, "north", "1.0");
  for (int i = 0; i < 500; ++i) spdlog::info("line {}", i);
  const std::string first = console.Read();
  EXPECT_THAT(first, ::testing::HasSubstr("line 0\n"));
  EXPECT_THAT(first, ::testing::Not(::testing::HasSubstr("line 499\n")));
  spdlog::info("after");
  EXPECT_THAT(console.Read(), ::testing::AllOf(::testing::HasSubstr("lines of the log were lost"),
                                               ::testing::EndsWith(" info after\n")));
}

TEST_F(LoggingTest, NothingWaitsForWhoReadsStandardError) {
  PipeAsStandardError console;
  NeverWaitForStandardError();
  for (int i = 0; i < 5000; ++i) std::fputs("a line of a library\n", stderr);
  EXPECT_THAT(console.Read(), ::testing::StartsWith("a line of a library\n"));
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
