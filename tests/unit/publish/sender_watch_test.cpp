// Two daemons of one name. Multicast needs a network of its own: tests/integration has the rest.
#include "publish/sender_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <memory>

#include "publish/instance.h"
#include "publish/lcm_publisher.h"
#include "support/log_capture.h"
#include "support/stepped_clock.h"
#include "unit/publish/messages.h"

namespace chequer {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A prefix that no other test uses, nor another run of this one on the same host.
std::string Prefix() { return "WATCH_" + std::to_string(getpid()); }

/// A server on this host, so that nothing but the claim tells them of each other.
LcmUrl Url() { return ParseLcmUrl("tcpq://127.0.0.1:1", LcmDirection::kPublish); }

MonotonicTime At(int second) { return MonotonicTime(seconds(second)); }

TEST(Instance, IsOneOfTheProcess) {
  EXPECT_EQ(InstanceOfProcess(), InstanceOfProcess());
  EXPECT_GT(InstanceOfProcess(), 0u);
  EXPECT_LT(InstanceOfProcess(), 1ull << 48);
  StatusMessage status;
  EXPECT_EQ(InstanceOf(status), std::nullopt);
  status.detections = {{"boards", 1}, {"instance", 7}};
  EXPECT_EQ(InstanceOf(status), 7u);
}

TEST(SenderWatch, BothOfTwoNoticeEachOther) {
  SenderWatch one(Url(), Prefix(), 1), other(Url(), Prefix(), 2), third(Url(), Prefix() + "_else", 3);
  for (int s = 0; s < 5; ++s)
    for (SenderWatch* watch : {&one, &other, &third}) {
      const std::string said = watch->Look(At(s));
      if (watch == &third || s == 0) {
        EXPECT_THAT(said, IsEmpty());
      } else if (s > 2) {
        EXPECT_THAT(said, HasSubstr("another program publishes as " + Prefix() + " too, on this host"));
      }
    }
}

TEST(SenderWatch, OneThatIsAloneAgainSaysNothing) {
  SenderWatch stays(Url(), Prefix(), 2);
  {
    SenderWatch goes(Url(), Prefix(), 1);
    for (int s = 0; s < 5; ++s) {
      goes.Look(At(s));
      stays.Look(At(s));
    }
    EXPECT_THAT(stays.Look(At(5)), HasSubstr("another"));
  }
  for (int s = 6; s < 9; ++s) stays.Look(At(s));
  EXPECT_THAT(stays.Look(At(9)), IsEmpty());
  SenderWatch next(Url(), Prefix(), 3);
  for (int s = 10; s < 13; ++s) {
    next.Look(At(s));
    stays.Look(At(s));
  }
  EXPECT_THAT(stays.Look(At(13)), HasSubstr("another")) << "it holds the name now";
}

TEST(SenderWatch, AnEndAndABeginningAreNoTwo) {
  auto first = std::make_unique<SenderWatch>(Url(), Prefix(), 1);
  for (int s = 0; s < 3; ++s) first->Look(At(s));
  SenderWatch second(Url(), Prefix(), 2);
  second.Look(At(3));
  first.reset();
  for (int s = 4; s < 8; ++s) EXPECT_THAT(second.Look(At(s)), IsEmpty()) << s;
}

TEST(LcmPublisher, SaysOnceThatThereIsAnother) {
  test::SteppedClock time;
  const std::string url = "tcpq://127.0.0.1:1";
  LcmPublisher one({url, Prefix(), 1}, time.clock()), other({url, Prefix(), 2}, time.clock());
  test::LogCapture log;
  for (int s = 0; s < 10; ++s) {
    one.Publish(test::SampleStatus());
    other.Publish(test::SampleStatus());
    time.Advance(seconds(1));
  }
  int said = 0;
  for (const std::string& line : log.lines()) said += line.find("another program publishes as") != std::string::npos;
  EXPECT_EQ(said, 2) << "each once";
}

}  // namespace
}  // namespace chequer
