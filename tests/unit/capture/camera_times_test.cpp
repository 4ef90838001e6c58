#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "capture/clock_fit.h"
#include "capture/frame_ids.h"
#include "capture/silence_watch.h"
#include "capture/v4l2_times.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

const ArrivalTimes kArrival{MonotonicTime(seconds(1000)), UtcTime(seconds(1'700'000'000))};

TEST(MapV4l2Times, MovesAMonotonicStampToUtc) {
  const auto times =
      MapV4l2Times(seconds(1000) - milliseconds(30), V4l2Clock::kMonotonic, ExposureInstant::kStart, kArrival);
  EXPECT_EQ(times.monotonic, kArrival.monotonic - milliseconds(30));
  EXPECT_EQ(times.utc, kArrival.utc - milliseconds(30));
  EXPECT_EQ(times.instant, ExposureInstant::kStart);
}

TEST(MapV4l2Times, KeepsOldStampsOfAKnownClock) {
  const auto times = MapV4l2Times(seconds(990), V4l2Clock::kMonotonic, ExposureInstant::kEnd, kArrival);
  EXPECT_EQ(times.monotonic, MonotonicTime(seconds(990)));
  EXPECT_EQ(times.utc, kArrival.utc - seconds(10));
}

TEST(MapV4l2Times, GuessesAnUnknownClock) {
  const auto monotonic =
      MapV4l2Times(seconds(1000) - milliseconds(9), V4l2Clock::kUnknown, ExposureInstant::kEnd, kArrival);
  EXPECT_EQ(monotonic.monotonic, kArrival.monotonic - milliseconds(9));
  const auto utc =
      MapV4l2Times(seconds(1'700'000'000) - milliseconds(7), V4l2Clock::kUnknown, ExposureInstant::kEnd, kArrival);
  EXPECT_EQ(utc.monotonic, kArrival.monotonic - milliseconds(7));
  EXPECT_EQ(utc.utc, kArrival.utc - milliseconds(7));
}

TEST(MapV4l2Times, TakesTheArrivalForWhatCannotBe) {
  for (const microseconds stamp : {microseconds(0), microseconds(seconds(2000)), microseconds(seconds(500))}) {
    const auto times = MapV4l2Times(stamp, V4l2Clock::kUnknown, ExposureInstant::kEnd, kArrival);
    EXPECT_EQ(times.monotonic, kArrival.monotonic);
    EXPECT_EQ(times.utc, kArrival.utc);
    EXPECT_EQ(times.instant, ExposureInstant::kUnknown);
  }
  const auto future =
      MapV4l2Times(seconds(1000) + milliseconds(1), V4l2Clock::kMonotonic, ExposureInstant::kEnd, kArrival);
  EXPECT_EQ(future.monotonic, kArrival.monotonic);
}

/// Frames of a camera whose clock began at another time and runs fast, over a network that delays them at random.
class ClockFitTest : public ::testing::Test {
 protected:
  static constexpr double kDrift = 50e-6;

  nanoseconds Device(double s) const { return nanoseconds(std::llround((7.5 + s * (1 + kDrift)) * 1e9)); }
  MonotonicTime Host(double s) const { return MonotonicTime(microseconds(std::llround((500 + s) * 1e6))); }

  /// Frames of some seconds, 30 a second.
  void Run(double from_s, double until_s) {
    std::exponential_distribution<double> late(1 / 2e-3);
    for (double s = from_s; s < until_s; s += 1.0 / 30) fit_.Add(Device(s), Host(s + kWay + late(random_)));
  }
  /// How far a mapped stamp is from the truth, microseconds.
  double Off(double s) const { return static_cast<double>((fit_.Map(Device(s)) - Host(s + kWay)).count()); }

  static constexpr double kWay = 200e-6;  ///< what even the fastest frame needs
  std::mt19937 random_{1};
  ClockFit fit_;
};

TEST_F(ClockFitTest, IsRightFromTheFirstFrameOn) {
  fit_.Add(Device(0), Host(kWay));
  EXPECT_EQ(Off(0), 0);
  EXPECT_EQ(fit_.error(), std::nullopt);
}

TEST_F(ClockFitTest, FollowsTheDriftThroughLateFrames) {
  Run(0, 30);
  EXPECT_LT(std::abs(Off(29.9)), 400);  // frames are 2 ms late on average
  ASSERT_TRUE(fit_.error());
  EXPECT_LT(*fit_.error(), microseconds(300));
  Run(30, 200);
  EXPECT_LT(std::abs(Off(199.9)), 250);  // without the drift it would be 10 ms
}

TEST_F(ClockFitTest, NeverMapsAFrameToAfterItsArrival) {
  std::uniform_real_distribution<double> late(0, 0.02);
  for (double s = 0; s < 20; s += 0.1) {
    const MonotonicTime arrived = Host(s + late(random_));
    fit_.Add(Device(s), arrived);
    EXPECT_LE(fit_.Map(Device(s)), arrived + microseconds(1));
  }
}

TEST_F(ClockFitTest, BeginsAnewWhereTheClockOfTheCameraJumps) {
  Run(0, 10);
  fit_.Add(nanoseconds(12345), Host(10));  // it was reset
  EXPECT_EQ(fit_.Map(nanoseconds(12345)), Host(10));
  EXPECT_EQ(fit_.error(), std::nullopt);
}

TEST(UtcOfPtp, KnowsTaiAndUtc) {
  const UtcTime fitted(seconds(1'700'000'000));
  const seconds tai(37);
  const microseconds tolerance = milliseconds(10);
  EXPECT_EQ(UtcOfPtp(seconds(1'700'000'037) + milliseconds(3), fitted, tai, tolerance), fitted + milliseconds(3));
  EXPECT_EQ(UtcOfPtp(seconds(1'700'000'000) - milliseconds(3), fitted, tai, tolerance), fitted - milliseconds(3));
  EXPECT_EQ(UtcOfPtp(seconds(1234), fitted, tai, tolerance), std::nullopt);
}

TEST(FrameIds, GoOnWhereTheyTurnOver) {
  FrameIds ids;
  EXPECT_EQ(ids.Number(65533), 65533u);
  EXPECT_EQ(ids.Number(65535), 65535u);
  EXPECT_EQ(ids.Number(1), 65536u);
  EXPECT_EQ(ids.Number(4), 65539u);
}

TEST(FrameIds, KeepWideOnesAndBeginAnew) {
  FrameIds ids;
  EXPECT_EQ(ids.Number(1ull << 40), 1ull << 40);
  EXPECT_EQ(ids.Number((1ull << 40) + 5), (1ull << 40) + 5);
  EXPECT_EQ(ids.Number(1), 1u);
}

TEST(SilenceWatch, WaitsForThreePeriodsAndAtLeastHalfASecond) {
  const MonotonicTime start(seconds(50));
  for (const auto& [period, limit] :
       {std::pair{milliseconds(20), milliseconds(500)}, {milliseconds(400), milliseconds(1200)}}) {
    SilenceWatch watch;
    watch.Opened(period, start);
    watch.Alive(start);
    EXPECT_FALSE(watch.IsSilent(start + limit - milliseconds(1)));
    EXPECT_TRUE(watch.IsSilent(start + limit));
  }
}

TEST(SilenceWatch, IsPatientUntilTheFirstFrame) {
  const MonotonicTime start(seconds(50));
  SilenceWatch watch;
  watch.Opened(milliseconds(20), start);
  EXPECT_FALSE(watch.IsSilent(start + milliseconds(2900)));
  EXPECT_TRUE(watch.IsSilent(start + milliseconds(3000)));
  EXPECT_EQ(watch.Message(start + milliseconds(3210)), "no frame for 3.2 s");
}

TEST(SilenceWatch, NeverCallsATriggeredCameraSilent) {
  SilenceWatch watch;
  watch.Opened(microseconds(0), MonotonicTime(seconds(50)));
  EXPECT_FALSE(watch.IsSilent(MonotonicTime(seconds(5000))));
}

}  // namespace
}  // namespace chequer
