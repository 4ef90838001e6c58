#include "daemon/restart_back_off.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <string>

#include "support/temporary_directory.h"

namespace chequer {
namespace {

using std::chrono::seconds;

UtcTime UtcAt(int s) { return UtcTime(seconds(1'700'000'000 + s)); }

TEST(RestartBackOff, DoublesUpToAMinute) {
  const test::TemporaryDirectory folder;
  int now = 0;
  for (const int expected : {0, 1, 2, 4, 8, 16, 32, 60, 60, 60}) {
    EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(now)), seconds(expected));
    now += expected + 3;
  }
}

TEST(RestartBackOff, DoesNotCountStartsThatEndedWell) {
  const test::TemporaryDirectory folder;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(i)), seconds(0)) << i;
    ForgetFailures(folder.path());
  }
  // One that failed between counts, and is forgotten by the next that ends well.
  EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(10)), seconds(0));
  EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(11)), seconds(1));
  ForgetFailures(folder.path());
  EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(12)), seconds(0));
  ForgetFailures("/nowhere/at/all");
}

TEST(RestartBackOff, DoesNotWaitAtAPipe) {
  const test::TemporaryDirectory folder;
  ASSERT_EQ(::mkfifo((folder / "starts").c_str(), 0600), 0);
  EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(0)), seconds(0));
}

TEST(RestartBackOff, ForgetsAfterALongRun) {
  const test::TemporaryDirectory folder;
  DelayBeforeStart(folder.path(), UtcAt(0));
  EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(10)), seconds(1));
  EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(1000)), seconds(0));
  EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(1001)), seconds(1));
}

TEST(RestartBackOff, BeginsAnewWhereTheFileIsNotItsOwnOrTheClockWentBack) {
  const test::TemporaryDirectory folder;
  for (const std::string text : {"", "rubbish", "-5 1700000000", "99999999999999999999 1", "3", "3 1800000000"}) {
    std::ofstream(folder / "starts", std::ios::trunc) << text;
    EXPECT_EQ(DelayBeforeStart(folder.path(), UtcAt(0)), seconds(0)) << text;
  }
}

TEST(RestartBackOff, DoesNotKeepTheDaemonFromStartingWithoutAFolder) {
  EXPECT_EQ(DelayBeforeStart("/nowhere/at/all", UtcAt(0)), seconds(0));
  EXPECT_EQ(DelayBeforeStart("/nowhere/at/all", UtcAt(1)), seconds(0));
}

}  // namespace
}  // namespace chequer
