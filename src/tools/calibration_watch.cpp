#include "tools/calibration_watch.h"

#include <stdexcept>
#include <utility>

#include "publish/lcm_subscriber.h"
#include "tools/setup_option.h"

namespace chequer {

CalibrationWatch::CalibrationWatch(const std::optional<CameraSetup>& setup) {
  camera_ = setup ? CameraNameIn(*setup) : "camera";
  try {
    const LcmUrl url = ParseLcmUrl(setup ? ListenUrlIn(*setup) : DefaultListenUrl(), LcmDirection::kPublish);
    const bool allowed = setup && setup->allow_view ? *setup->allow_view : !url.LeavesTheHost();
    if (allowed) channel_.emplace(url, setup ? PrefixIn(*setup) : "CHEQUER_camera");
  } catch (const std::runtime_error&) {
    // A calibration does not need LCM; chequerd and `chequer view` say what is wrong with its URL.
  }
}

void CalibrationWatch::Send(CalibrationMessage message) {
  if (!channel_) return;
  message.camera = camera_;
  message.utc = clock_.utc();
  channel_->Send(message);
}

}  // namespace chequer
