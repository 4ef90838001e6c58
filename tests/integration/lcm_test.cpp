#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "integration/workspace.h"
#include "publish/lcm_publisher.h"
#include "unit/publish/messages.h"

namespace chequer {
namespace {

using std::chrono::seconds;
using test::SamplePoses;
using test::SampleStatus;
using test::SetMulticastRoute;
using test::Subscriber;
using ::testing::HasSubstr;

LcmPublisherOptions Options() { return {std::string("udpm://239.255.76.67:7667?ttl=0"), "CHEQUER_test"}; }

TEST(LcmIntegration, MessagesArriveWhole) {
  Subscriber subscriber;
  LcmPublisher publisher(Options());
  EXPECT_TRUE(publisher.Publish(SamplePoses(8)));
  EXPECT_TRUE(publisher.Publish(SampleStatus()));
  ASSERT_TRUE(subscriber.ReceiveUntil([](const auto& got) { return got.statuses.size() == 1; }));
  ASSERT_EQ(subscriber.received().poses.size(), 1u);
  EXPECT_EQ(subscriber.received().poses[0].markers.size(), 8u);
  EXPECT_EQ(subscriber.received().poses[0].camera, "ceiling");
}

// 106496 asked for is 212992 granted, what a process that asks for nothing has on a stock kernel.
TEST(LcmIntegration, AThousandMarkersArriveInAStockReceiveBuffer) {
  Subscriber subscriber("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=106496");
  LcmPublisher publisher(Options());
  PosesMessage message = SamplePoses(1000);
  for (std::uint64_t i = 0; i < 60; ++i) {
    message.sequence = i;
    ASSERT_TRUE(publisher.Publish(message));
    ASSERT_TRUE(subscriber.ReceiveUntil([&](const auto& got) { return got.poses.size() == i + 1; }, seconds(5)));
    const PosesMessage& got = subscriber.received().poses.back();
    ASSERT_EQ(got.sequence, i);
    ASSERT_EQ(got.markers.size(), 1000u);
    ASSERT_EQ(got.markers[999].id, 999u);
  }
}

TEST(LcmIntegration, ALostRouteIsCountedForSmallAndLargeMessagesAndHealsItself) {
  Subscriber subscriber;
  LcmPublisher publisher(Options());
  ASSERT_TRUE(publisher.Publish(SamplePoses(1)));
  SetMulticastRoute(false);
  EXPECT_FALSE(publisher.Publish(SamplePoses(1)));
  EXPECT_FALSE(publisher.Publish(SamplePoses(1000)));  // of several datagrams: LCM itself does not tell
  EXPECT_EQ(publisher.health().failed, 2u);
  EXPECT_EQ(publisher.health().state, PublisherState::kFailing);
  EXPECT_THAT(publisher.health().message, HasSubstr("udpm://239.255.76.67:7667"));
  SetMulticastRoute(true);
  EXPECT_TRUE(publisher.Publish(SamplePoses(3)));
  EXPECT_EQ(publisher.health().state, PublisherState::kReady);
  ASSERT_TRUE(subscriber.ReceiveUntil([](const auto& got) { return got.poses.size() == 2; }));
  EXPECT_EQ(subscriber.received().poses[1].markers.size(), 3u);
}

TEST(LcmIntegration, AMissingRouteIsNamedWithItsRemedy) {
  SetMulticastRoute(false);
  const LcmPublisher publisher(Options());
  EXPECT_EQ(publisher.health().state, PublisherState::kWaiting);
  EXPECT_THAT(publisher.health().message, HasSubstr("udpm://239.255.76.67:7667?ttl=0"));
  EXPECT_THAT(publisher.health().message, HasSubstr("ip route add 224.0.0.0/4 dev lo"));
  EXPECT_THROW(Subscriber(), std::runtime_error);
}

}  // namespace
}  // namespace chequer
