#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <variant>
#include <vector>

#include "core/clock.h"
#include "core/repeated_cause.h"
#include "daemon/progress.h"
#include "daemon/statistics.h"
#include "publish/publisher.h"

namespace chequer {

/// Stands before a publisher that may have to wait: for a server that does not read, or a disk. Whoever publishes here
/// does not wait with it; messages queue up for a thread of their own. Where too many do, the oldest is dropped and
/// counted, as the newest poses are worth the most.
class Outbox final : public Publisher {
 public:
  enum class WhenFull {
    kDropOldest,
    kWait,  ///< a recording that is worked on as fast as it goes: nothing is lost
  };
  /// At 60 frames a second and three messages a frame, a quarter of a second.
  static constexpr std::size_t kCapacity = 64;

  /// @param behind used by the thread in Run alone. @param sending tells how long it is at one message.
  Outbox(Publisher& behind, WhenFull when_full, Activity& sending, Clock clock);

  bool Publish(const PosesMessage& message) override { return Put({message}); }
  bool Publish(const StatusMessage& message) override { return Put({message}); }
  bool Publish(const RobotsMessage& message) override { return Put({message}); }
  bool Publish(const TracksMessage& message) override { return Put({message}); }
  bool PublishInCamera(const PosesMessage& message) override { return Put({message, true}); }
  /// That of the publisher behind, after the last message that it was handed; with what was dropped here.
  PublisherHealth health() const override;

  /// All messages of a frame were put: TakeSent tells of it when they have been sent.
  void EndFrame(const FrameTimes& times) { Put({times}); }
  /// The frames that were sent since the last call, with the time of that.
  std::vector<FrameTimes> TakeSent();

  /// Sends what comes until it is closed: what the thread does.
  void Run();
  /// From now on nobody waits for room. Any thread.
  void StopWaiting();
  /// Waits until all is sent; false when the time is over.
  bool WaitUntilSent(std::chrono::milliseconds patience);
  /// Ends Run, at once if it sends nothing. What was not sent is dropped and counted.
  void Close();

  /// Messages that were dropped here.
  std::uint64_t dropped() const;

 private:
  struct Message {
    std::variant<PosesMessage, StatusMessage, RobotsMessage, TracksMessage, FrameTimes> content;
    bool in_camera = false;
  };
  bool Put(Message message);
  void Send(const Message& message);
  /// Makes room.
  Message DropOldest();
  void KeepsUp();

  Publisher& behind_;
  Activity& sending_;
  Clock clock_;
  mutable std::mutex mutex_;
  std::condition_variable put_, sent_;
  std::deque<Message> waiting_;
  std::vector<FrameTimes> frames_sent_;
  PublisherHealth health_;  ///< of the publisher behind
  std::uint64_t dropped_ = 0;
  std::uint64_t dropped_before_ = 0;  ///< the present trouble
  RepeatedCause trouble_;
  bool drops_;  ///< when full
  bool busy_ = false;
  bool closed_ = false;
  bool behind_hand_ = false;  ///< messages were dropped, and not all that wait are sent yet
};

}  // namespace chequer
