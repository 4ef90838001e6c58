#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "core/command_line.h"
#include "daemon/command_line.h"
#include "daemon/config.h"
#include "daemon/daemon.h"
#include "daemon/logging.h"
#include "setup/camera_setup.h"

namespace {

int RunConfigured(const chequer::DaemonCommandLine& command_line) {
  std::optional<chequer::DaemonConfig> config;
  std::filesystem::path file;
  try {
    file = chequer::FindCameraSetup(command_line.config.empty() ? chequer::kSetupHere : command_line.config);
    config = chequer::LoadDaemonConfig(file);
    chequer::CheckCpus(config->scheduling.cpus);
    if (command_line.check) chequer::CheckRecording(config->capture);
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "chequerd: %s\n", error.what());
    return chequer::kDaemonBadConfig;
  }
  for (const std::string& remark : config->remarks) std::fprintf(stderr, "chequerd: warning: %s\n", remark.c_str());
  if (command_line.check) return chequer::kDaemonOk;
  chequer::SetUpLogging(config->log, config->camera_name, CHEQUER_VERSION);
  try {
    chequer::RunDaemon(*config, file, CHEQUER_VERSION);
    return chequer::kDaemonOk;
  } catch (const chequer::ServiceLost& error) {
    spdlog::critical("{}", error.what());
    return chequer::kDaemonFailed;
  } catch (const std::system_error& error) {
    spdlog::critical("{}", error.what());
    return chequer::kDaemonFailed;
  } catch (const std::runtime_error& error) {
    // Only what no waiting repairs comes out as an error; a camera that is not there is waited for.
    spdlog::critical("{}", error.what());
    return chequer::kDaemonBadConfig;
  } catch (const std::exception& error) {
    spdlog::critical("{}", error.what());
    return chequer::kDaemonFailed;
  }
}

/// Runs before the initialisers of all libraries, which take 20 ms: a SIGHUP that comes meanwhile would end the process.
/// (Not every system's C library looks here; main holds them again.)
[[gnu::section(".preinit_array"), gnu::used]] void (*const hold_signals)() = chequer::HoldSignals;

}  // namespace

int main(int argc, char** argv) {
  chequer::HoldSignals();
  chequer::NeverWaitForStandardError();
  CLI::App app;
  chequer::DaemonCommandLine command_line;
  chequer::DescribeDaemon(app, command_line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "chequerd: %s\n", chequer::CommandLineTrouble(app, error).c_str());
    return chequer::kDaemonUsage;
  }
  std::error_code unknown;
  if (command_line.config.empty() && !std::filesystem::is_regular_file(chequer::kSetupHere, unknown)) {
    std::fprintf(stderr, "chequerd: --config is required where there is no ./%s\n", chequer::kSetupHere);
    return chequer::kDaemonUsage;
  }
  return RunConfigured(command_line);
}
