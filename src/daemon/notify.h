#pragma once

#include <string>
#include <string_view>

#include "publish/messages.h"

namespace chequer {

// What a daemon tells its service manager (sd_notify(3)). All do nothing where nobody asked to be told (no
// NOTIFY_SOCKET in the environment). Any thread.

void NotifyReady();
void NotifyStopping();
/// One line for `systemctl status`.
void NotifyStatus(const std::string& line);
/// Says that the daemon lives, if the unit asks for it (WatchdogSec=). Called with each status, so once a second: the
/// unit's time must leave room for some of them.
void NotifyAlive();

/// The line that says how the daemon fares, such as "60.0 frames/s, 49.5 markers a frame, 3 frames dropped" or
/// "waiting for the camera: …".
std::string StatusLine(const StatusMessage& status);

}  // namespace chequer
