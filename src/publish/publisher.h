#pragma once

#include "publish/messages.h"

namespace chequer {

/// Sends messages to whoever listens. One thread calls it. It never throws for trouble outside the program, never
/// waits for it to pass but for a moment (LcmSink::Send), and tells of it in health(). Who may not wait even that long
/// has an Outbox before it.
class Publisher {
 public:
  virtual ~Publisher() = default;

  /// Whether the message was taken; if not, it is gone and counted.
  virtual bool Publish(const PosesMessage& message) = 0;
  virtual bool Publish(const StatusMessage& message) = 0;
  virtual bool Publish(const RobotsMessage& message) = 0;
  virtual bool Publish(const TracksMessage& message) = 0;
  /// A frame that was published in the world once more, in the camera's own frame of reference, on a channel of its
  /// own.
  virtual bool PublishInCamera(const PosesMessage& message) = 0;

  virtual PublisherHealth health() const = 0;
};

}  // namespace chequer
