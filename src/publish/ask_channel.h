#pragma once

#include <optional>
#include <string>

#include "core/unique_fd.h"
#include "publish/channel_listener.h"
#include "publish/view_messages.h"

namespace chequer {

/// Hears the requests of those who look at one camera: the one thing that a daemon ever hears. Where LCM's ttl is 0 it
/// hears them over the loopback interface alone. What floods it is dropped by the kernel, and it reads a bounded number
/// at a time. One thread.
class AskListener {
 public:
  AskListener(const LcmUrl& url, const std::string& prefix);

  /// The next request that came; nothing where that was all, or many were read since the last pause.
  std::optional<AskMessage> Next();
  /// Readable where something came; −1 while no multicast can be had.
  int fd() const { return listener_.fd(); }

 private:
  ChannelListener listener_;
};

/// Sends requests: over the loopback interface, where daemons whose messages do not leave the host hear them, and by
/// the group's route. Without LCM's library, which knows the route alone. One thread.
class AskSender {
 public:
  /// URLs of other providers than multicast: nothing is sent.
  explicit AskSender(const LcmUrl& url);

  /// Whether one of the two ways took it.
  bool Send(const std::string& prefix, const AskMessage& message);

 private:
  LcmUrl url_;
  UniqueFd over_loopback_, by_route_;
  std::uint32_t number_ = 0;
};

}  // namespace chequer
