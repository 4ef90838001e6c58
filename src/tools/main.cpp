#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "core/command_line.h"
#include "core/printable.h"
#include "tools/application.h"
#include "tools/commands.h"

namespace {

/// "chequer", or "chequer COMMAND" (or "chequer COMMAND PART") once the command line has got that far.
std::string Prefix(const CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app.get_name() : app.get_name() + " " + Prefix(*commands.front());
}

int Fail(const CLI::App& app, const char* message, int status) {
  // Messages quote what files, devices and the network say.
  std::fprintf(stderr, "%s: %s\n", Prefix(app).c_str(), chequer::PrintableLines(message).c_str());
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app;
  chequer::DescribeTool(app);

  try {
    app.parse(argc, argv);
    return chequer::kExitOk;
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::RuntimeError& reported) {
    return reported.get_exit_code();
  } catch (const CLI::ParseError& error) {
    return Fail(app, chequer::CommandLineTrouble(app, error).c_str(), chequer::kExitUsage);
  } catch (const std::exception& error) {
    return Fail(app, error.what(), chequer::kExitInput);
  }
}
