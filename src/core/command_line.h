#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/suggestion.h"

// Inline, so that the core needs no parser of command lines: chequer and chequerd, which have one, share the words.

namespace chequer {

/// The command that was typed last: "world" of "chequer calibrate world".
inline const CLI::App& TypedCommand(const CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app : TypedCommand(*commands.front());
}

/// What is wrong with a word that no command or option takes, and what was probably meant.
inline std::string UnexpectedWord(const CLI::App& command, const std::string& typed) {
  if (typed.size() > 1 && typed.front() == '-') {
    const std::string option = typed.substr(0, typed.find('='));
    std::vector<std::string> known;
    for (const CLI::Option* each : command.get_options())
      for (const std::string& name : each->get_lnames()) known.push_back("--" + name);
    const std::string nearest = DidYouMean(option, known);
    return "there is no option " + option + (nearest.empty() ? "; --help lists them all" : nearest);
  }
  std::vector<std::string> commands;
  for (const CLI::App* each : command.get_subcommands({})) commands.push_back(each->get_name());
  if (!commands.empty()) return UnknownWord("a command", typed, commands);
  const CLI::Option* missing = nullptr;
  for (const CLI::Option* each : command.get_options())
    if (each->get_required() && each->empty() && missing == nullptr) missing = each;
  const CLI::Option* config = command.get_option_no_throw("--config");
  if (missing == nullptr && config != nullptr && config->empty() && typed.ends_with(".toml")) missing = config;
  return "'" + typed + "' was not expected" +
         (missing == nullptr ? std::string() : "; did you mean " + missing->get_name() + " " + typed + "?");
}

/// What to say of a command line that cannot be parsed. @pre `app` threw `error`.
inline std::string CommandLineTrouble(const CLI::App& app, const CLI::ParseError& error) {
  const bool about_words = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
                           dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  if (!about_words) return error.what();
  const CLI::App& command = TypedCommand(app);
  const std::vector<std::string> words = command.remaining();
  for (const std::string& word : words)  // an option first: words behind it may be its values
    if (word.size() > 1 && word.front() == '-') return UnexpectedWord(command, word);
  if (!words.empty()) return UnexpectedWord(command, words.front());
  const auto commands = command.get_subcommands({});
  if (commands.empty()) return error.what();
  std::string known;
  for (const CLI::App* each : commands) known.append(known.empty() ? "" : ", ").append(each->get_name());
  return "a command is missing; known are " + known;
}

}  // namespace chequer
