#include "daemon/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/watchdog.h"
#include "support/log_capture.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

MonotonicTime AtSecond(double s) { return MonotonicTime(milliseconds(static_cast<int>(s * 1000))); }

const ProgressLimits kLimits{.work = seconds(5), .opening = seconds(120)};

TEST(Progress, HasNothingToSayOfPartsThatWait) {
  Progress progress(3);
  EXPECT_THAT(progress.Stuck(AtSecond(1e6), kLimits), IsEmpty());
}

TEST(Progress, NamesTheWorkerThatHangs) {
  Progress progress(3);
  progress.worker(1).Begin(AtSecond(10));
  EXPECT_THAT(progress.Stuck(AtSecond(15), kLimits), IsEmpty());
  EXPECT_THAT(progress.Stuck(AtSecond(17), kLimits), AllOf(HasSubstr("worker 1"), HasSubstr("7.0 s")));
  progress.worker(1).End();
  EXPECT_THAT(progress.Stuck(AtSecond(17), kLimits), IsEmpty());
}

TEST(Progress, NamesTheCauseRatherThanWhatFollowsFromIt) {
  Progress progress(2);
  progress.frames.BeginUnlessBegun(AtSecond(0));
  EXPECT_THAT(progress.Stuck(AtSecond(6), kLimits), HasSubstr("none has been published"));
  progress.publishing.Begin(AtSecond(0));
  EXPECT_THAT(progress.Stuck(AtSecond(6), kLimits), HasSubstr("publishing one message"));
  progress.sending.Begin(AtSecond(0));
  EXPECT_THAT(progress.Stuck(AtSecond(6), kLimits), HasSubstr("handing one message to LCM"));
  progress.capture.capturing.Begin(AtSecond(0));
  EXPECT_THAT(progress.Stuck(AtSecond(6), kLimits), HasSubstr("camera's thread"));
  progress.worker(0).Begin(AtSecond(0));
  EXPECT_THAT(progress.Stuck(AtSecond(6), kLimits), HasSubstr("worker 0"));
}

TEST(Progress, KnowsASlowFrameFromOneThatHangs) {
  std::uint64_t pieces = 0;
  Progress progress(2, [&](int worker) { return worker == 1 ? pieces : 0; });
  progress.frames.BeginUnlessBegun(AtSecond(0));
  progress.worker(1).Begin(AtSecond(0));
  for (int s = 1; s <= 60; ++s) {
    ++pieces;
    EXPECT_THAT(progress.Stuck(AtSecond(s), kLimits), IsEmpty()) << s;
  }
  EXPECT_THAT(progress.Stuck(AtSecond(65), kLimits), IsEmpty());
  EXPECT_THAT(progress.Stuck(AtSecond(66), kLimits), AllOf(HasSubstr("worker 1"), HasSubstr("6.0 s")));
  ++pieces;
  EXPECT_THAT(progress.Stuck(AtSecond(67), kLimits), IsEmpty());
}

TEST(Progress, DoesNotTakeThePiecesOfFormerFramesForProgress) {
  std::uint64_t pieces = 1000;
  Progress progress(1, [&](int) { return pieces; });
  EXPECT_THAT(progress.Stuck(AtSecond(0), kLimits), IsEmpty());
  progress.worker(0).Begin(AtSecond(1));
  EXPECT_THAT(progress.Stuck(AtSecond(7), kLimits), HasSubstr("worker 0"));
}

TEST(Progress, RenewsOnlyWhatHasBegun) {
  Activity activity;
  activity.Renew(AtSecond(1));
  EXPECT_EQ(activity.Lasting(AtSecond(5)), std::nullopt);
  activity.Begin(AtSecond(1));
  activity.Renew(AtSecond(4));
  EXPECT_EQ(activity.Lasting(AtSecond(5)), seconds(1));
}

TEST(Progress, NamesWhatIsUnderWay) {
  Progress progress(2);
  EXPECT_THAT(progress.UnderWay(AtSecond(1)), IsEmpty());
  progress.worker(1).Begin(AtSecond(0));
  progress.capture.opening.Begin(AtSecond(0));
  EXPECT_EQ(progress.UnderWay(AtSecond(1)), "worker 1 is at a frame, the camera is being opened");
  EXPECT_EQ(progress.busy_workers(AtSecond(1)), 1);
}

TEST(Progress, LeavesACameraMoreTimeToOpen) {
  Progress progress(1);
  progress.capture.opening.Begin(AtSecond(0));
  EXPECT_THAT(progress.Stuck(AtSecond(100), kLimits), IsEmpty());
  EXPECT_THAT(progress.Stuck(AtSecond(121), kLimits), HasSubstr("opening the camera"));
}

TEST(Progress, CountsFromTheFirstFrameThatWasNotPublished) {
  Progress progress(1);
  for (int s = 0; s < 6; ++s) progress.frames.BeginUnlessBegun(AtSecond(s));
  EXPECT_EQ(progress.frames.Lasting(AtSecond(6)), seconds(6));
  progress.frames.End();
  progress.frames.BeginUnlessBegun(AtSecond(7));
  EXPECT_EQ(progress.frames.Lasting(AtSecond(8)), seconds(1));
}

TEST(Watchdog, FeedsWhileThereIsProgressAndSaysOnceWhatHangs) {
  test::LogCapture log;
  Watchdog watchdog(seconds(10));
  int fed = 0;
  const auto look = [&](const char* stuck) { watchdog.Look(stuck, [&] { ++fed; }); };
  look("");
  look("");
  EXPECT_EQ(fed, 2);
  look("worker 0 hangs");
  look("worker 0 hangs");
  EXPECT_EQ(fed, 2);
  look("");
  EXPECT_EQ(fed, 3);
  ASSERT_EQ(log.lines().size(), 2u);
  EXPECT_THAT(log.lines()[0], HasSubstr("worker 0 hangs"));
}

TEST(Watchdog, FindsAHangOutBeforeTheWatchdogEnds) {
  const Watchdog quick(seconds(2));
  EXPECT_EQ(quick.period(), milliseconds(500));
  EXPECT_EQ(quick.limits().work, seconds(1));
  const Watchdog slow(seconds(60));
  EXPECT_EQ(slow.period(), seconds(1));
  EXPECT_EQ(slow.limits().work, ProgressLimits{}.work);
  EXPECT_EQ(Watchdog(std::nullopt).limits().work, ProgressLimits{}.work);
}

}  // namespace
}  // namespace chequer
