#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "publish/wire.h"

namespace chequer {

/// Which channels are listened to. All empty: every channel named like ours, *_POSES, *_STATUS, *_TRACKS and so on.
struct ChannelFilter {
  std::string prefix;   ///< <prefix>_POSES, <prefix>_STATUS, <prefix>_TRACKS and so on
  std::string channel;  ///< this channel alone, whatever its name
  bool view = false;    ///< beside those also what is published on request: *_PREVIEW, *_DETAIL, *_SETUP

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// The URL tools listen at unless told otherwise: the environment's LCM_DEFAULT_URL as with every LCM program, else
/// LCM's own group with room for large messages in the receive buffer.
std::string DefaultListenUrl();
/// Where the messages that are published at a URL are heard: multicast with that room, unless the URL says how much.
std::string ListenUrlFor(const std::string& published);

/// Receives what publishers send. One thread.
class LcmSubscriber {
 public:
  using Handler = std::function<void(const std::string& channel, ReceivedMessage&& message)>;

  /// Throws std::runtime_error naming the URL, what is wrong and the remedy where LCM cannot be opened there, or the
  /// filter is not valid.
  LcmSubscriber(const std::string& url, const ChannelFilter& filter, Handler handler);
  /// The same, for who decodes what comes.
  using BytesHandler = std::function<void(const std::string& channel, std::span<const std::uint8_t> bytes)>;
  static LcmSubscriber OfBytes(const std::string& url, const ChannelFilter& filter, BytesHandler handler);
  ~LcmSubscriber();
  LcmSubscriber(LcmSubscriber&&) noexcept;
  LcmSubscriber& operator=(LcmSubscriber&&) noexcept;

  enum class Outcome { kMessage, kTimeout, kClosed };
  /// Waits for one message and hands it to the handler. kClosed: nothing more will come (a log is at its end, the
  /// server is gone).
  Outcome Wait(std::chrono::milliseconds timeout);

  /// Readable where a message came; −1 where a log is read.
  int fd() const;

  /// Messages on our channels that could not be understood, such as those of another version.
  std::uint64_t unreadable() const;

 private:
  struct Impl;
  explicit LcmSubscriber(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer
