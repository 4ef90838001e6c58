#include "daemon/notify.h"

#include <spdlog/fmt/fmt.h>
#include <systemd/sd-daemon.h>

#include <cstdint>

namespace chequer {

void NotifyReady() { sd_notify(0, "READY=1"); }

void NotifyStopping() { sd_notify(0, "STOPPING=1"); }

void NotifyStatus(const std::string& line) { sd_notify(0, ("STATUS=" + line).c_str()); }

void NotifyAlive() {
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(0, &period_us) > 0) sd_notify(0, "WATCHDOG=1");
}

std::string StatusLine(const StatusMessage& status) {
  if (status.camera_state == CameraState::kWaiting)
    return status.camera_message.empty() ? "waiting for the camera"
                                         : "waiting for the camera: " + status.camera_message;
  if (!status.publisher.message.empty()) return status.publisher.message;
  if (!status.camera_message.empty()) return status.camera_message;
  return fmt::format("{:.1f} frames/s, {:.1f} markers a frame, {} frames dropped", status.publish_rate_hz,
                     status.markers_mean, status.frames_dropped);
}

}  // namespace chequer
