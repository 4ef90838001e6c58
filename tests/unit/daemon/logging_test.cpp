#include "daemon/logging.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

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
  SetUpLogging({LogLevel::kWarning, LogTarget::kConsole});
  EXPECT_FALSE(spdlog::should_log(spdlog::level::info));
  EXPECT_TRUE(spdlog::should_log(spdlog::level::warn));
  SetUpLogging({LogLevel::kDebug, LogTarget::kConsole});
  EXPECT_TRUE(spdlog::should_log(spdlog::level::debug));
}

}  // namespace
}  // namespace chequer
