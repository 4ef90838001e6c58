#pragma once

#include <optional>
#include <string>

#include "publish/channel_listener.h"
#include "publish/messages.h"

namespace chequer {

/// Hears the statuses on one channel of a multicast group, and nothing else. One thread.
class StatusListener {
 public:
  /// Where no multicast can be had it hears nothing and tries again. URLs of other providers: it hears nothing.
  StatusListener(const LcmUrl& url, std::string channel);

  struct Heard {
    StatusMessage status;
    std::string from;  ///< address of the host that sent it
  };
  /// What came since the last call and was not given yet, one by one; nothing where that was all. Does not wait.
  std::optional<Heard> Next();

 private:
  ChannelListener listener_;
};

}  // namespace chequer
