#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "tools/application.h"
#include "tools/commands.h"

namespace {

/// "chequer", or "chequer COMMAND" (or "chequer COMMAND PART") once the command line has got that far.
std::string Prefix(const CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app.get_name() : app.get_name() + " " + Prefix(*commands.front());
}

int Fail(const CLI::App& app, const char* message, int status) {
  std::fprintf(stderr, "%s: %s\n", Prefix(app).c_str(), message);
  return status;
}

/// What to say where the first word is no command, or there is none.
std::string UnknownCommand(const CLI::App& app) {
  std::string known;
  for (const CLI::App* command : app.get_subcommands({}))
    known.append(known.empty() ? "" : ", ").append(command->get_name());
  const auto words = app.remaining();
  return (words.empty() ? "a command is missing" : "'" + words.front() + "' is not a command") + "; known are " + known;
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
    const bool no_command = app.get_subcommands().empty();
    return Fail(app, no_command ? UnknownCommand(app).c_str() : error.what(), chequer::kExitUsage);
  } catch (const std::exception& error) {
    return Fail(app, error.what(), chequer::kExitInput);
  }
}
