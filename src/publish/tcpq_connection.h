#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/unique_fd.h"
#include "publish/lcm_url.h"

namespace chequer {

/// A connection to an LCM TCP server, for publishing. LCM's own waits for ever for a server that accepts and says
/// nothing, or that stops reading; this one gives up in time. One thread.
class TcpqConnection {
 public:
  /// How long connecting and greeting may take together, and how long sending one message.
  static constexpr std::chrono::milliseconds kPatience{500};

  /// Connects and exchanges greetings. Throws std::runtime_error saying what went wrong, without the URL.
  explicit TcpqConnection(const LcmUrl& url);

  /// Empty if the message went out whole; else why not, and the connection is of no use any more.
  std::string Send(const std::string& channel, std::span<const std::uint8_t> message);

 private:
  UniqueFd socket_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace chequer
