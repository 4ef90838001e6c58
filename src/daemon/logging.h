#pragma once

#include "daemon/config.h"

namespace chequer {

/// Whether systemd connected standard error to the journal (systemd.exec(5), JOURNAL_STREAM).
bool StandardErrorIsJournal();

/// Directs the process's log, the one global there is. Standard output stays free.
void SetUpLogging(const LogOptions& options);

}  // namespace chequer
