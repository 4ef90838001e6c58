#include "daemon/command_line.h"

#include <CLI/CLI.hpp>

namespace chequer {

void DescribeDaemon(CLI::App& app, DaemonCommandLine& command_line) {
  app.name("chequerd");
  app.description("Finds colour-checkerboard markers in a camera's frames and publishes their poses over LCM.");
  app.add_option(
         "--config", command_line.config,
         "Configuration (TOML), or NAME for NAME.toml, here or in /etc/chequer; chequerd.toml(5) documents every key "
         "[./chequer.toml, if it is there]")
      ->type_name("NAME|FILE");
  app.add_flag("--check", command_line.check,
               "Read the configuration, the files and the recording it names, say what is wrong or risky, end");
  app.set_version_flag("--version", std::string("chequerd ") + CHEQUER_VERSION);
  app.footer(
      "SIGTERM and SIGINT end it, within two seconds; SIGHUP makes it read its configuration again: the camera stays\n"
      "open where [capture] did not change, and a configuration that cannot work is refused whole.\n\n"
      "Exit status: 0 when asked to end or when the recording is over, 78 where the configuration cannot work, 2 "
      "where\n"
      "the command line is wrong, 1 for anything else.\n\n"
      "Example:\n"
      "  chequerd --config /etc/chequer/north.toml");
}

}  // namespace chequer
