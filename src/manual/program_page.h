#pragma once

#include <string>
#include <string_view>

namespace CLI {
class App;
}

namespace chequer {

/// What the page of a program says that its `--help` does not.
struct ProgramPage {
  int section = 1;
  std::string summary;   ///< what apropos(1) shows
  std::string more;      ///< sections in troff, put behind what `--help` says
  std::string see_also;  ///< such as "chequer(1), chequerd.toml(5)"
};

/// The manual page of a program, in troff, from what its command line is parsed by: description, options and their
/// texts, commands, footers.
std::string ManualPage(const CLI::App& app, std::string_view version, const ProgramPage& page);

}  // namespace chequer
