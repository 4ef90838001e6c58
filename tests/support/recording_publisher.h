#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "publish/publisher.h"

namespace chequer::test {

/// What was published, for a test to wait for and to look at. Any thread.
class Published {
 public:
  void Add(const PosesMessage& message);
  void Add(const StatusMessage& message);
  void Add(const RobotsMessage& message);
  void Add(const TracksMessage& message);
  void AddInCamera(const PosesMessage& message);

  std::vector<PosesMessage> poses() const;
  std::vector<StatusMessage> statuses() const;
  std::vector<RobotsMessage> robots() const;
  std::vector<TracksMessage> tracks() const;
  std::vector<PosesMessage> in_camera() const;

  /// Waits until that many frames were published; false after ten seconds.
  bool WaitForPoses(std::size_t count) const;
  bool WaitForStatuses(std::size_t count) const;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::vector<PosesMessage> poses_;
  std::vector<StatusMessage> statuses_;
  std::vector<RobotsMessage> robots_;
  std::vector<TracksMessage> tracks_;
  std::vector<PosesMessage> in_camera_;
};

/// A publisher that keeps what it is given.
class RecordingPublisher final : public Publisher {
 public:
  explicit RecordingPublisher(std::shared_ptr<Published> published) : published_(std::move(published)) {}

  bool Publish(const PosesMessage& message) override { return Count(message); }
  bool Publish(const StatusMessage& message) override { return Count(message); }
  bool Publish(const RobotsMessage& message) override { return Count(message); }
  bool Publish(const TracksMessage& message) override { return Count(message); }
  bool PublishInCamera(const PosesMessage& message) override {
    published_->AddInCamera(message);
    return true;
  }
  PublisherHealth health() const override { return health_; }

 private:
  template <typename Message>
  bool Count(const Message& message) {
    health_.state = PublisherState::kReady;
    ++health_.sent;
    published_->Add(message);
    return true;
  }

  std::shared_ptr<Published> published_;  ///< shared: the test looks at it while and after the pipeline runs
  PublisherHealth health_;
};

}  // namespace chequer::test
