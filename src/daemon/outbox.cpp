#include "daemon/outbox.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

namespace chequer {
namespace {

constexpr const char* kTooSlow = "LCM takes messages more slowly than they come, the oldest are dropped";

}  // namespace

Outbox::Outbox(Publisher& behind, WhenFull when_full, Activity& sending, Clock clock)
    : behind_(behind),
      sending_(sending),
      clock_(std::move(clock)),
      health_(behind.health()),
      drops_(when_full == WhenFull::kDropOldest) {}

bool Outbox::Put(Message message) {
  Message oldest;  // dies after the lock is released
  {
    std::unique_lock lock(mutex_);
    sent_.wait(lock, [this] { return drops_ || closed_ || waiting_.size() < kCapacity; });
    if (closed_) {
      ++dropped_;
      return false;
    }
    if (waiting_.size() >= kCapacity) oldest = DropOldest();
    waiting_.push_back(std::move(message));
  }
  put_.notify_one();
  return true;
}

Outbox::Message Outbox::DropOldest() {
  Message oldest = std::move(waiting_.front());
  waiting_.pop_front();
  if (std::holds_alternative<FrameTimes>(oldest.content)) return oldest;
  if (!std::exchange(behind_hand_, true)) dropped_before_ = dropped_;
  ++dropped_;
  if (const std::string log = trouble_.Occurred(kTooSlow, {}, clock_.monotonic()); !log.empty())
    spdlog::error("{}", log);
  return oldest;
}

void Outbox::KeepsUp() {
  if (!std::exchange(behind_hand_, false)) return;
  trouble_.Ended();
  spdlog::info("LCM keeps up again; {} messages were dropped", dropped_ - dropped_before_);
}

void Outbox::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    put_.wait(lock, [this] { return closed_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    Message message = std::move(waiting_.front());
    waiting_.pop_front();
    if (auto* times = std::get_if<FrameTimes>(&message.content)) {
      times->sent = clock_.monotonic();
      frames_sent_.push_back(*times);
    } else {
      busy_ = true;
      lock.unlock();
      Send(message);
      PublisherHealth health = behind_.health();
      lock.lock();
      busy_ = false;
      health_ = std::move(health);
    }
    if (waiting_.empty()) KeepsUp();
    sent_.notify_all();
  }
}

void Outbox::Send(const Message& message) {
  sending_.Begin(clock_.monotonic());
  if (const auto* poses = std::get_if<PosesMessage>(&message.content))
    message.in_camera ? behind_.PublishInCamera(*poses) : behind_.Publish(*poses);
  else if (const auto* status = std::get_if<StatusMessage>(&message.content))
    behind_.Publish(*status);
  else if (const auto* robots = std::get_if<RobotsMessage>(&message.content))
    behind_.Publish(*robots);
  else if (const auto* tracks = std::get_if<TracksMessage>(&message.content))
    behind_.Publish(*tracks);
  sending_.End();
}

PublisherHealth Outbox::health() const {
  const std::lock_guard lock(mutex_);
  PublisherHealth health = health_;
  health.failed += dropped_;
  if (!behind_hand_ || !health.message.empty()) return health;
  health.state = PublisherState::kFailing;
  health.message = kTooSlow;
  return health;
}

std::vector<FrameTimes> Outbox::TakeSent() {
  const std::lock_guard lock(mutex_);
  return std::exchange(frames_sent_, {});
}

void Outbox::StopWaiting() {
  {
    const std::lock_guard lock(mutex_);
    drops_ = true;
  }
  sent_.notify_all();
}

bool Outbox::WaitUntilSent(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return sent_.wait_for(lock, patience, [this] { return waiting_.empty() && !busy_; });
}

void Outbox::Close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    dropped_ += static_cast<std::uint64_t>(std::count_if(waiting_.begin(), waiting_.end(), [](const Message& message) {
      return !std::holds_alternative<FrameTimes>(message.content);
    }));
    waiting_.clear();
  }
  put_.notify_all();
  sent_.notify_all();
}

std::uint64_t Outbox::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace chequer
