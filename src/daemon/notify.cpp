#include "daemon/notify.h"

#include <spdlog/fmt/fmt.h>
#include <systemd/sd-daemon.h>

#include <cstdint>
#include <ctime>

namespace chequer {

void NotifyReady() { sd_notify(0, "READY=1"); }

void NotifyReloading() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  // Later versions of systemd want to know which reload it was.
  sd_notify(0, fmt::format("RELOADING=1\nMONOTONIC_USEC={}", now.tv_sec * 1'000'000 + now.tv_nsec / 1000).c_str());
}

void NotifyStopping() { sd_notify(0, "STOPPING=1"); }

void NotifyStatus(const std::string& line) { sd_notify(0, ("STATUS=" + line).c_str()); }

void NotifyStarting(std::chrono::microseconds may_take) {
  sd_notify(0, fmt::format("EXTEND_TIMEOUT_USEC={}", may_take.count()).c_str());
}

void NotifyAlive() { sd_notify(0, "WATCHDOG=1"); }

std::optional<std::chrono::microseconds> WatchdogPeriod() {
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(0, &period_us) <= 0) return std::nullopt;
  return std::chrono::microseconds(period_us);
}

std::string StatusLine(const StatusMessage& status) {
  if (status.camera_state == CameraState::kWaiting)
    return status.camera_message.empty() ? "waiting for the camera"
                                         : "waiting for the camera: " + status.camera_message;
  if (!status.publisher.message.empty()) return status.publisher.message;
  if (!status.camera_message.empty()) return status.camera_message;
  std::string line = fmt::format("{:.1f} frames/s, {:.1f} markers a frame, {} frames dropped", status.publish_rate_hz,
                                 status.markers_mean, status.frames_dropped);
  for (const StageLatency& stage : status.stages)
    if (stage.stage == "total" && stage.frames > 0)
      line += fmt::format(", latency {:.1f} ms (99 %: {:.1f} ms)", static_cast<double>(stage.median.count()) / 1000,
                          static_cast<double>(stage.p99.count()) / 1000);
  return line;
}

}  // namespace chequer
