#include "support/recording_publisher.h"

namespace chequer::test {
namespace {

constexpr std::chrono::seconds kDeadline{10};

}  // namespace

void Published::Add(const PosesMessage& message) {
  {
    const std::lock_guard lock(mutex_);
    poses_.push_back(message);
  }
  changed_.notify_all();
}

void Published::Add(const StatusMessage& message) {
  {
    const std::lock_guard lock(mutex_);
    statuses_.push_back(message);
  }
  changed_.notify_all();
}

std::vector<PosesMessage> Published::poses() const {
  const std::lock_guard lock(mutex_);
  return poses_;
}

std::vector<StatusMessage> Published::statuses() const {
  const std::lock_guard lock(mutex_);
  return statuses_;
}

bool Published::WaitForPoses(std::size_t count) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kDeadline, [&] { return poses_.size() >= count; });
}

bool Published::WaitForStatuses(std::size_t count) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kDeadline, [&] { return statuses_.size() >= count; });
}

}  // namespace chequer::test
