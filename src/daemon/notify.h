#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "publish/messages.h"

namespace chequer {

// What a daemon tells its service manager (sd_notify(3)). All do nothing where nobody asked to be told (no
// NOTIFY_SOCKET in the environment). None waits: what a service manager does not read yet is sent with the next. Any
// thread.

void NotifyReady();
/// The configuration is being read again; NotifyReady follows.
void NotifyReloading();
void NotifyStopping();
/// One line for `systemctl status`.
void NotifyStatus(const std::string& line);
/// It is still starting and makes progress: the time it may take runs anew.
void NotifyStarting(std::chrono::microseconds may_take);
/// Says that the daemon makes progress.
void NotifyAlive();

/// How often the service manager wants to hear that the daemon is alive (WatchdogSec= of the unit), if at all.
std::optional<std::chrono::microseconds> WatchdogPeriod();

/// The line that says how the daemon fares, such as "60.0 frames/s, 49.5 markers a frame, 3 frames dropped, latency
/// 5.2 ms (99 %: 8.1 ms)" or "waiting for the camera: …".
std::string StatusLine(const StatusMessage& status);

}  // namespace chequer
