#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "daemon/config.h"
#include "daemon/daemon.h"
#include "daemon/logging.h"

namespace {

int RunConfigured(const std::string& file) {
  std::optional<chequer::DaemonConfig> config;
  try {
    config = chequer::LoadDaemonConfig(file);
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "chequerd: %s\n", error.what());
    return chequer::kDaemonBadConfig;
  }
  chequer::SetUpLogging(config->log);
  try {
    chequer::RunDaemon(*config, CHEQUER_VERSION);
    return chequer::kDaemonOk;
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

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Finds colour-checkerboard markers in a camera's frames and publishes their poses over LCM.",
               "chequerd");
  std::string file;
  app.add_option("--config", file, "Configuration (TOML); config/chequerd.toml documents every key")
      ->required()
      ->type_name("FILE");
  app.set_version_flag("--version", std::string("chequerd ") + CHEQUER_VERSION);
  app.footer("Example: chequerd --config /etc/chequer/chequerd.toml");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "chequerd: %s\n", error.what());
    return chequer::kDaemonUsage;
  }
  return RunConfigured(file);
}
