#pragma once

#include <string>

#include "daemon/log_options.h"

namespace chequer {

/// Whether systemd connected standard error to the journal (systemd.exec(5), JOURNAL_STREAM).
bool StandardErrorIsJournal();

/// From then on nothing that this process writes to standard error waits for a slow reader; it is lost instead.
void NeverWaitForStandardError();

/// Directs the process's log, the one global there is. Standard output stays free. Not while other threads log.
/// @param camera, version in each record of the journal, as CHEQUER_CAMERA and CHEQUER_VERSION.
void SetUpLogging(const LogOptions& options, const std::string& camera, const std::string& version);

}  // namespace chequer
