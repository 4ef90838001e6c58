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

/// Runs the daemon until the recording is over or SIGINT or SIGTERM comes; reads the configuration again on SIGHUP.
/// Blocks these signals, so it must be called before any thread is started. Throws std::runtime_error where the source
/// can never work.
/// @param file what the configuration was read from.
void RunDaemon(const DaemonConfig& config, const std::filesystem::path& file, const std::string& version);

}  // namespace chequer
