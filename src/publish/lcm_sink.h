#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/clock.h"
#include "publish/lcm_url.h"

namespace chequer {

/// Where encoded messages go to, while it is open. One thread.
class LcmSink {
 public:
  virtual ~LcmSink() = default;

  /// Empty if the message went out, else why not. Gives up within TcpqConnection::kPatience where a network is waited
  /// for.
  virtual std::string Send(const std::string& channel, std::span<const std::uint8_t> message) = 0;
  /// Whether it may work again after a message that did not go out; if not, another must be opened.
  virtual bool Recovers() const = 0;
};

/// Opens it. Nothing where that fails now; `problem` then names the URL, what is missing, and the remedy.
/// @param clock tells the times that a log's messages get.
std::unique_ptr<LcmSink> OpenLcmSink(const LcmUrl& url, const Clock& clock, std::string& problem);

}  // namespace chequer
