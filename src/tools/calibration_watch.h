#pragma once

#include <optional>
#include <string>

#include "publish/calibration_channel.h"
#include "publish/view_messages.h"
#include "setup/camera_setup.h"

namespace chequer {

/// Shows a calibration to the pages of `chequer view` while it runs: on the camera's channels, as the configuration
/// names them. Silent where the configuration forbids looking ([view] allow), and by default where LCM's messages leave
/// the host, as chequerd is. One thread.
class CalibrationWatch {
 public:
  /// @param setup nothing: the camera "camera", where LCM programs listen.
  explicit CalibrationWatch(const std::optional<CameraSetup>& setup);

  /// Whether a message is worth making now: somebody looks, and the last one is a while ago.
  bool IsDue() { return channel_ && channel_->IsDue(); }
  /// Whether somebody looks: for what is sent once.
  bool IsWatched() { return channel_ && channel_->IsAsked(); }
  /// Sends it with the camera's name and the time.
  void Send(CalibrationMessage message);

 private:
  Clock clock_ = Clock::System();
  std::string camera_;
  std::optional<CalibrationChannel> channel_;
};

}  // namespace chequer
