#include "core/repeated_cause.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/back_off.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::IsEmpty;

MonotonicTime At(int second) { return MonotonicTime(seconds(second)); }

TEST(RepeatedCause, LogsTheFirstAndThenCounts) {
  RepeatedCause cause;
  EXPECT_EQ(cause.Occurred("no frame", "a.png", At(0)), "no frame: a.png");
  EXPECT_THAT(cause.Occurred("no frame", "b.png", At(1)), IsEmpty());
  EXPECT_THAT(cause.Occurred("no frame", "c.png", At(59)), IsEmpty());
  EXPECT_EQ(cause.Occurred("no frame", "d.png", At(60)), "no frame: d.png (3 times in the last 60 s)");
}

TEST(RepeatedCause, RemindsMoreAndMoreSeldomDownToAnHour) {
  RepeatedCause cause;
  std::vector<int> logged;
  for (int second = 0; second < 20000; ++second)
    if (!cause.Occurred("x", {}, At(second)).empty()) logged.push_back(second);
  EXPECT_THAT(logged, ::testing::ElementsAre(0, 60, 180, 420, 900, 1860, 3780, 7380, 10980, 14580, 18180));
}

TEST(RepeatedCause, LogsAnotherCauseAtOnce) {
  RepeatedCause cause;
  cause.Occurred("gone", {}, At(0));
  EXPECT_EQ(cause.Occurred("busy", {}, At(1)), "busy");
}

TEST(RepeatedCause, StartsAnewAfterItsEnd) {
  RepeatedCause cause;
  EXPECT_EQ(cause.Ended(), 0u);
  cause.Occurred("gone", {}, At(0));
  cause.Occurred("gone", {}, At(1));
  EXPECT_EQ(cause.Ended(), 2u);
  EXPECT_EQ(cause.Ended(), 0u);
  EXPECT_EQ(cause.Occurred("gone", {}, At(2)), "gone");
}

TEST(BackOff, DoublesUpToItsLongestAndStartsAnew) {
  BackOff back_off(milliseconds(100), milliseconds(350));
  EXPECT_EQ(back_off.Failed(), milliseconds(100));
  EXPECT_EQ(back_off.Failed(), milliseconds(200));
  EXPECT_EQ(back_off.Failed(), milliseconds(350));
  EXPECT_EQ(back_off.Failed(), milliseconds(350));
  back_off.Succeeded();
  EXPECT_EQ(back_off.Failed(), milliseconds(100));
}

}  // namespace
}  // namespace chequer
