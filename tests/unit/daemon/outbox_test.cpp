#include "daemon/outbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "support/deadline.h"
#include "support/log_capture.h"
#include "support/recording_publisher.h"
#include "support/semaphore.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using test::kPatience;
using test::Published;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Takes a message each time that it is let.
class SlowPublisher final : public Publisher {
 public:
  explicit SlowPublisher(std::shared_ptr<Published> published) : behind_(std::move(published)) {}

  bool Publish(const PosesMessage& message) override { return Wait() && behind_.Publish(message); }
  bool Publish(const StatusMessage& message) override { return Wait() && behind_.Publish(message); }
  bool Publish(const RobotsMessage& message) override { return Wait() && behind_.Publish(message); }
  bool Publish(const TracksMessage& message) override { return Wait() && behind_.Publish(message); }
  bool PublishInCamera(const PosesMessage& message) override { return Wait() && behind_.PublishInCamera(message); }
  PublisherHealth health() const override { return behind_.health(); }

  test::Semaphore entered{0}, open{0};

 private:
  bool Wait() {
    entered.release();
    return open.try_acquire_for(kPatience);
  }
  test::RecordingPublisher behind_;
};

class OutboxTest : public ::testing::Test {
 protected:
  ~OutboxTest() override {
    slow_.open.release(5000);
    outbox_->Close();
    thread_.join();
  }
  void Start(Outbox::WhenFull when_full) {
    outbox_.emplace(slow_, when_full, sending_, Clock::System());
    thread_ = std::thread([this] { outbox_->Run(); });
  }
  static PosesMessage Poses(std::uint64_t sequence) {
    PosesMessage message;
    message.sequence = sequence;
    return message;
  }
  std::vector<std::uint64_t> Sequences() const {
    std::vector<std::uint64_t> sequences;
    for (const PosesMessage& message : published_->poses()) sequences.push_back(message.sequence);
    return sequences;
  }

  test::LogCapture log_;
  std::shared_ptr<Published> published_ = std::make_shared<Published>();
  SlowPublisher slow_{published_};
  Activity sending_;
  std::optional<Outbox> outbox_;
  std::thread thread_;
};

TEST_F(OutboxTest, HandsOnEveryKindOfMessageInOrder) {
  Start(Outbox::WhenFull::kDropOldest);
  slow_.open.release(100);
  EXPECT_TRUE(outbox_->Publish(Poses(1)));
  EXPECT_TRUE(outbox_->PublishInCamera(Poses(1)));
  EXPECT_TRUE(outbox_->Publish(RobotsMessage{}));
  EXPECT_TRUE(outbox_->Publish(TracksMessage{}));
  EXPECT_TRUE(outbox_->Publish(StatusMessage{}));
  EXPECT_TRUE(outbox_->Publish(Poses(2)));
  ASSERT_TRUE(outbox_->WaitUntilSent(kPatience));
  EXPECT_THAT(Sequences(), ElementsAre(1, 2));
  EXPECT_EQ(published_->in_camera().size(), 1u);
  EXPECT_EQ(published_->robots().size(), 1u);
  EXPECT_EQ(published_->tracks().size(), 1u);
  EXPECT_EQ(published_->statuses().size(), 1u);
  EXPECT_EQ(outbox_->health().sent, 5u);  // the recording one does not count those in the camera's frame
}

TEST_F(OutboxTest, NeverWaitsAndDropsTheOldest) {
  Start(Outbox::WhenFull::kDropOldest);
  EXPECT_TRUE(outbox_->Publish(Poses(1)));
  ASSERT_TRUE(slow_.entered.try_acquire_for(kPatience));  // it is being sent
  for (std::uint64_t i = 2; i <= 3 + Outbox::kCapacity; ++i) EXPECT_TRUE(outbox_->Publish(Poses(i)));
  EXPECT_EQ(outbox_->dropped(), 2u);
  EXPECT_EQ(outbox_->health().failed, 2u);
  EXPECT_EQ(outbox_->health().state, PublisherState::kFailing);
  EXPECT_THAT(outbox_->health().message, HasSubstr("more slowly than they come"));
  slow_.open.release(1000);
  ASSERT_TRUE(outbox_->WaitUntilSent(kPatience));
  const std::vector<std::uint64_t> sequences = Sequences();
  ASSERT_EQ(sequences.size(), 1 + Outbox::kCapacity);
  EXPECT_EQ(sequences[0], 1u);
  EXPECT_EQ(sequences[1], 4u);
  EXPECT_EQ(sequences.back(), 3 + Outbox::kCapacity);
  EXPECT_EQ(outbox_->health().state, PublisherState::kReady);
  EXPECT_EQ(outbox_->health().failed, 2u);
  ASSERT_EQ(log_.lines().size(), 2u);
  EXPECT_THAT(log_.lines()[0], HasSubstr("the oldest are dropped"));
  EXPECT_THAT(log_.lines()[1], HasSubstr("keeps up again; 2 messages were dropped"));
}

TEST_F(OutboxTest, WaitsForRoomWhereNothingIsToBeLost) {
  Start(Outbox::WhenFull::kWait);
  constexpr std::uint64_t kMany = 3 * Outbox::kCapacity;
  std::thread publishing([&] {
    for (std::uint64_t i = 1; i <= kMany; ++i) EXPECT_TRUE(outbox_->Publish(Poses(i)));
  });
  slow_.open.release(1000);
  publishing.join();
  ASSERT_TRUE(outbox_->WaitUntilSent(kPatience));
  EXPECT_EQ(Sequences().size(), kMany);
  EXPECT_EQ(outbox_->dropped(), 0u);
}

TEST_F(OutboxTest, LetsGoOfWhoWaitsForRoomWhenItIsToStop) {
  Start(Outbox::WhenFull::kWait);
  std::thread publishing([&] {
    for (std::uint64_t i = 1; i <= 2 * Outbox::kCapacity; ++i) outbox_->Publish(Poses(i));
  });
  ASSERT_TRUE(slow_.entered.try_acquire_for(kPatience));
  outbox_->StopWaiting();
  publishing.join();
  EXPECT_FALSE(outbox_->WaitUntilSent(milliseconds(1)));
  outbox_->Close();
  EXPECT_GE(outbox_->dropped(), Outbox::kCapacity);
  EXPECT_FALSE(outbox_->Publish(Poses(1)));
}

TEST_F(OutboxTest, TellsWhenAFrameWasSent) {
  Start(Outbox::WhenFull::kDropOldest);
  outbox_->Publish(Poses(1));
  FrameTimes times;
  times.captured = MonotonicTime(milliseconds(5));
  outbox_->EndFrame(times);
  ASSERT_TRUE(slow_.entered.try_acquire_for(kPatience));
  EXPECT_TRUE(outbox_->TakeSent().empty());
  const MonotonicTime before = Clock::System().monotonic();
  slow_.open.release();
  ASSERT_TRUE(outbox_->WaitUntilSent(kPatience));
  const std::vector<FrameTimes> sent = outbox_->TakeSent();
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].captured, times.captured);
  EXPECT_GE(sent[0].sent, before);
  EXPECT_TRUE(outbox_->TakeSent().empty());
}

TEST_F(OutboxTest, TellsThatAMessageTakesLong) {
  Start(Outbox::WhenFull::kDropOldest);
  const Clock clock = Clock::System();
  EXPECT_FALSE(sending_.Lasting(clock.monotonic()).has_value());
  outbox_->Publish(Poses(1));
  ASSERT_TRUE(slow_.entered.try_acquire_for(kPatience));
  EXPECT_TRUE(sending_.Lasting(clock.monotonic()).has_value());
  slow_.open.release();
  ASSERT_TRUE(outbox_->WaitUntilSent(kPatience));
  EXPECT_FALSE(sending_.Lasting(clock.monotonic()).has_value());
}

}  // namespace
}  // namespace chequer
