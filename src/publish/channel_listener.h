#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/unique_fd.h"
#include "publish/lcm_url.h"

namespace chequer {

/// From which interfaces messages are heard.
enum class HeardFrom : std::uint8_t {
  kDefaultRoute,         ///< where the host has the group's route
  kThisHost,             ///< over the loopback interface alone: nobody else can reach it
  kDefaultRouteAndHost,  ///< both
};

struct ChannelListenerOptions {
  HeardFrom from = HeardFrom::kDefaultRoute;
  std::size_t max_datagram = 65536;  ///< longer ones are dropped
  int receive_buffer = 0;            ///< bytes; 0: the system's default
};

/// Hears the short messages (of one datagram) on one channel of a multicast group, and nothing else: the kernel drops
/// what comes on other channels, or is too long. A subscriber of LCM would take all messages of all cameras, and stop
/// for seconds where a firewall keeps multicast from it. One thread.
class ChannelListener {
 public:
  /// Where no multicast can be had it hears nothing and tries again. URLs of other providers: it hears nothing.
  ChannelListener(const LcmUrl& url, std::string channel, ChannelListenerOptions options = {});

  struct Heard {
    std::span<const std::uint8_t> message;  ///< valid until the next call
    std::string from;                       ///< address of the host that sent it
  };
  /// What came since the last call and was not given yet, one by one; nothing where that was all. Does not wait.
  std::optional<Heard> Next();

  /// Readable where something came; −1 while no multicast can be had.
  int fd() const { return socket_.valid() ? socket_.get() : -1; }

 private:
  void Open();

  LcmUrl url_;
  std::string channel_;
  ChannelListenerOptions options_;
  UniqueFd socket_;
  std::vector<std::uint8_t> datagram_;
};

}  // namespace chequer
