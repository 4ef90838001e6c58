#pragma once

#include <string>

namespace CLI {
class App;
}

namespace chequer {

/// What chequerd is asked for.
struct DaemonCommandLine {
  std::string config;  ///< a file, or the name of one; empty: ./chequer.toml
  bool check = false;  ///< read it and end
};

/// Gives `chequerd` its description and options: what the program parses, and what its manual page and the completion
/// of the shell are made from. @param command_line gets what is parsed; must outlive `app`.
void DescribeDaemon(CLI::App& app, DaemonCommandLine& command_line);

}  // namespace chequer
