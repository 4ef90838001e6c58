#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/unique_fd.h"
#include "publish/lcm_url.h"
#include "publish/messages.h"

namespace chequer {

/// Hears the statuses on one channel of a multicast group, and nothing else: the kernel drops what comes on other
/// channels. A subscriber of LCM would take all messages of all cameras, and stop for seconds where a firewall keeps
/// multicast from it. One thread.
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
  void Open();

  LcmUrl url_;
  std::string channel_;
  UniqueFd socket_;
  std::vector<std::uint8_t> datagram_;
};

}  // namespace chequer
