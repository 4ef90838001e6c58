#pragma once

#include <filesystem>
#include <string>

#include "daemon/config.h"
#include "daemon/service.h"

namespace chequer {

/// Exit statuses of chequerd.
inline constexpr int kDaemonOk = 0;          ///< asked to stop, or the recording is over
inline constexpr int kDaemonFailed = 1;      ///< something broke that should not
inline constexpr int kDaemonUsage = 2;       ///< the command line is wrong
inline constexpr int kDaemonBadConfig = 78;  ///< EX_CONFIG: starting again cannot help

/// A detector as a worker calls it. Throws std::runtime_error where the options are not valid.
DetectFrame MakeDetectFrame(const DetectorOptions& options);

/// Blocks the signals that RunDaemon heeds, so that one that comes early waits for it, and ignores SIGPIPE: a reader of
/// the log or of a metrics page that goes away must not end the daemon. To be called before any thread is started, as
/// early as can be.
void HoldSignals();

/// Runs the daemon until the recording is over or SIGINT or SIGTERM comes; reads the configuration again on SIGHUP.
/// Leaves the process where a thread does not end when it is to stop. Throws std::runtime_error where the source can
/// never work. @pre HoldSignals was called.
/// @param file what the configuration was read from.
void RunDaemon(const DaemonConfig& config, const std::filesystem::path& file, const std::string& version);

}  // namespace chequer
