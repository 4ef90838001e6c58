#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/clock.h"
#include "publish/ask_channel.h"
#include "view/client_message.h"
#include "view/feed.h"

namespace chequer {

/// What is to be asked of one camera for all pages that look: the whole frame, and a part of it.
struct CameraAsks {
  AskMessage whole;
  AskMessage part;
  bool any = false;
};

/// What pages of these wishes need of a camera. Where several look at different parts of it, the last one's is asked
/// for; the others have the whole frame.
CameraAsks AsksFor(std::uint16_t camera, const std::vector<PageWish>& wishes, std::int64_t asker);

/// Whether one of them shows calibrations.
bool AsksForCalibrations(const std::vector<PageWish>& wishes);

/// Asks the daemons for what pages need, and calibrations, again before it runs out. One thread.
class RequestSender {
 public:
  /// @param asker as of Feed.
  RequestSender(const LcmUrl& url, std::int64_t asker) : sender_(url), asker_(asker) {}

  /// To be called some ten times a second, and when a page wishes something else.
  void Ask(const Feed& feed, const std::vector<PageWish>& wishes, MonotonicTime now);

 private:
  struct Sent {
    std::vector<std::uint8_t> what;
    MonotonicTime at{};
  };
  AskSender sender_;
  std::int64_t asker_;
  std::map<std::string, Sent> sent_;
  MonotonicTime next_calibration_{};
};

}  // namespace chequer
