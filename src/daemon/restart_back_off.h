#pragma once

#include <chrono>
#include <filesystem>

#include "chequer/frame.h"

namespace chequer {

/// How long to wait before starting, when the service manager starts the daemon again after a failure: nothing the
/// first time, then 1, 2, 4 … 60 s. Starts that did not end well are counted in a file of `folder`, which lives as long
/// as the manager goes on trying (RuntimeDirectoryPreserve=restart) and is gone when somebody stops the service; one
/// that comes more than five minutes after the last begins anew. A folder that cannot be used gives no wait: it must
/// not keep the daemon from its work. (systemd has a back-off of its own from version 254 on.)
std::chrono::seconds DelayBeforeStart(const std::filesystem::path& folder, UtcTime now);

/// To be called when the daemon ends because it was asked to, or because its work is done: the start was no failure,
/// and the next one does not wait. A restart by hand or by a package that is upgraded is none either.
void ForgetFailures(const std::filesystem::path& folder);

}  // namespace chequer
