#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "core/clock.h"
#include "publish/ask_channel.h"
#include "publish/lcm_sink.h"
#include "publish/view_messages.h"

namespace chequer {

/// Tells those who look how far a calibration has come, while one of them asks for it on kCalibrationPrefix; nothing is
/// sent before. What floods it with requests costs it a bounded time. One thread.
class CalibrationChannel {
 public:
  static constexpr std::chrono::seconds kAskLasts{2};
  static constexpr std::chrono::milliseconds kPeriod{200};

  /// URLs of other providers than multicast: nobody is heard, nothing is sent.
  /// @param prefix of the camera's channels.
  CalibrationChannel(const LcmUrl& url, std::string prefix, Clock clock = Clock::System());

  /// Whether somebody asked within kAskLasts.
  bool IsAsked();
  /// Whether somebody asks, and the last message was sent kPeriod ago or more.
  bool IsDue();
  /// Where LCM cannot be opened the message is lost: a calibration goes on without those who look.
  void Send(const CalibrationMessage& message);

 private:
  LcmUrl url_;
  std::string prefix_;
  Clock clock_;
  AskListener asks_;
  std::optional<MonotonicTime> asked_until_, next_;
  std::unique_ptr<LcmSink> sink_;
};

}  // namespace chequer
