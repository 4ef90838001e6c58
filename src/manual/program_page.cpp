#include "manual/program_page.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

#include "manual/troff.h"

namespace chequer {
namespace {

std::vector<const CLI::Option*> Shown(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });
}

/// A command that does something, with its whole name: "chequer calibrate lens".
struct Command {
  const CLI::App* app;
  std::string name;
};

/// Commands that are only there to hold others are left out.
std::vector<Command> Commands(const CLI::App& app, const std::string& name) {
  std::vector<Command> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* sub) { return !sub->get_name().empty(); })) {
    const std::string whole = name + " " + command->get_name();
    const std::vector<Command> parts = Commands(*command, whole);
    if (parts.empty()) commands.push_back({command, whole});
    commands.insert(commands.end(), parts.begin(), parts.end());
  }
  return commands;
}

/// "\fB\-\-name\fR \fITYPE\fR", all names of the option.
std::string Term(const CLI::Option& option) {
  std::string names;
  const auto add = [&](const std::string& name) {
    names += (names.empty() ? "\\fB" : ", \\fB") + Troff(name) + "\\fR";
  };
  for (const std::string& name : option.get_snames()) add("-" + name);
  for (const std::string& name : option.get_lnames()) add("--" + name);
  const std::string type = option.get_items_expected_max() == 0 ? std::string() : option.get_type_name();
  if (names.empty()) return "\\fI" + Troff(type.empty() ? option.get_name(true) : type) + "\\fR";
  return type.empty() ? names : names + " \\fI" + Troff(type) + "\\fR";
}

std::string Options(const CLI::App& app) {
  std::string text;
  for (const CLI::Option* option : Shown(app)) {
    text += ".TP\n" + Term(*option) + "\n" + Troff(option->get_description()) + ".\n";
    if (const std::string value = option->get_default_str(); !value.empty()) text += "Default: " + Troff(value) + ".\n";
    if (option->get_required()) text += "Must be given.\n";
  }
  return text;
}

std::string Synopsis(const CLI::App& app, const std::string& name) {
  std::string line = "\\fB" + Troff(name) + "\\fR";
  for (const CLI::Option* option : Shown(app))
    if (option->get_required() && !option->get_lnames().empty()) line += " " + Term(*option);
  const bool has_more = std::any_of(Shown(app).begin(), Shown(app).end(), [](const CLI::Option* option) {
    return !option->get_required() && !option->get_lnames().empty();
  });
  if (has_more) line += " [\\fIOPTION\\fR...]";
  for (const CLI::Option* option : Shown(app))
    if (option->get_lnames().empty() && option->get_snames().empty()) {
      const std::string term = Term(*option);
      const std::string many = option->get_items_expected_max() > 1 ? "..." : "";
      line += option->get_required() ? " " + term + many : " [" + term + many + "]";
    }
  return line + "\n";
}

}  // namespace

std::string ManualPage(const CLI::App& app, std::string_view version, const ProgramPage& page) {
  std::string title = app.get_name();
  std::transform(title.begin(), title.end(), title.begin(),
                 [](char c) { return static_cast<char>(std::toupper(static_cast<unsigned char>(c))); });
  std::string text = TroffHead(title, page.section, version, app.get_name(), page.summary) + ".SH SYNOPSIS\n";
  const std::vector<Command> commands = Commands(app, app.get_name());
  if (commands.empty()) text += Synopsis(app, app.get_name());
  for (const Command& command : commands)
    text += (&command == &commands.front() ? "" : ".br\n") + Synopsis(*command.app, command.name);
  text += ".SH DESCRIPTION\n" + TroffParagraphs(app.get_description());
  text += ".SH OPTIONS\n" + Options(app);
  if (!commands.empty()) text += ".SH COMMANDS\n";
  for (const Command& command : commands)
    text += ".SS " + Troff(command.name) + "\n" + TroffParagraphs(command.app->get_description()) +
            Options(*command.app) + ".PP\n" + TroffParagraphs(command.app->get_footer());
  if (!app.get_footer().empty()) text += ".SH NOTES\n" + TroffParagraphs(app.get_footer());
  return text + page.more + ".SH SEE ALSO\n" + Troff(page.see_also) + "\n";
}

}  // namespace chequer
