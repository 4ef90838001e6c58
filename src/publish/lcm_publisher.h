#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/clock.h"
#include "publish/instance.h"
#include "publish/publisher.h"

namespace chequer {

struct LcmPublisherOptions {
  std::string url{"udpm://239.255.76.67:7667?ttl=0"};
  /// Channels are <prefix>_POSES, <prefix>_STATUS and so on (channels.h).
  std::string prefix = "CHEQUER";
  /// Tells this publisher from others of the same prefix; published with each status.
  std::uint64_t instance = InstanceOfProcess();

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// Publishes over LCM, or into a log. While LCM cannot be opened (no multicast route, say) messages are lost and
/// counted, one log message names the URL and the remedy, and opening is tried again with back-off as messages come.
/// Where another program publishes as the same camera, the log and health() say so.
class LcmPublisher : public Publisher {
 public:
  /// Tries to open LCM; that it fails is no error. A log is opened by the first message. Throws std::runtime_error with
  /// Check's message if the options are not valid.
  explicit LcmPublisher(LcmPublisherOptions options, Clock clock = Clock::System());
  ~LcmPublisher() override;

  bool Publish(const PosesMessage& message) override;
  bool Publish(const StatusMessage& message) override;
  bool Publish(const RobotsMessage& message) override;
  bool Publish(const TracksMessage& message) override;
  bool PublishInCamera(const PosesMessage& message) override;
  PublisherHealth health() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer
