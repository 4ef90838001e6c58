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

void Published::Add(const RobotsMessage& message) {
  const std::lock_guard lock(mutex_);
  robots_.push_back(message);
}

void Published::Add(const TracksMessage& message) {
  const std::lock_guard lock(mutex_);
  tracks_.push_back(message);
}

void Published::AddInCamera(const PosesMessage& message) {
  const std::lock_guard lock(mutex_);
  in_camera_.push_back(message);
}

std::vector<PosesMessage> Published::poses() const {
  const std::lock_guard lock(mutex_);
  return poses_;
}

std::vector<StatusMessage> Published::statuses() const {
  const std::lock_guard lock(mutex_);
  return statuses_;
}

std::vector<RobotsMessage> Published::robots() const {
  const std::lock_guard lock(mutex_);
  return robots_;
}

std::vector<TracksMessage> Published::tracks() const {
  const std::lock_guard lock(mutex_);
  return tracks_;
}

std::vector<PosesMessage> Published::in_camera() const {
  const std::lock_guard lock(mutex_);
  return in_camera_;
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
