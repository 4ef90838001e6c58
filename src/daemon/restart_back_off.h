#pragma once

#include <chrono>
#include <filesystem>

#include "chequer/frame.h"

namespace chequer {

/// How long to wait before starting, when the service manager starts the daemon again after a failure: nothing the
/// first time, then 1, 2, 4 … 60 s. Starts are counted in a file of `folder`, which lives as long as the manager goes
/// on trying (RuntimeDirectoryPreserve=restart) and is gone when somebody stops the service; one that comes more than
/// five minutes after the last begins anew. A folder that cannot be used gives no wait: it must not keep the daemon
/// from its work. (systemd has a back-off of its own from version 254 on.)
std::chrono::seconds DelayBeforeStart(const std::filesystem::path& folder, UtcTime now);

}  // namespace chequer
