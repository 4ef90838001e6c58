#include "manual/completion.h"

#include <CLI/CLI.hpp>

namespace chequer {
namespace {

bool WantsFile(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.find("FILE") != std::string::npos || type.find("FOLDER") != std::string::npos ||
         type.find("RECORDING") != std::string::npos || type.find("PATH") != std::string::npos ||
         type.find("DIR") != std::string::npos;
}

/// Options of one command, as the words and the patterns of a case.
struct Words {
  std::string options;  ///< "--url --json"
  std::string files;    ///< "--config|--out": those whose value is a file
  std::string valued;   ///< those with any other value
};

Words WordsOf(const CLI::App& app) {
  Words words;
  const auto add = [](std::string& list, const char* separator, const std::string& name) {
    list += (list.empty() ? "" : separator) + name;
  };
  for (const CLI::Option* option : app.get_options())
    for (const std::string& lname : option->get_lnames()) {
      const std::string name = "--" + lname;
      add(words.options, " ", name);
      if (option->get_items_expected_max() == 0) continue;
      add(WantsFile(*option) ? words.files : words.valued, "|", name);
    }
  return words;
}

/// Of a command with parts: their names and what any of them takes.
Words WordsWithParts(const CLI::App& command) {
  Words words = WordsOf(command);
  const auto add = [](std::string& list, const std::string& more, const char* separator) {
    if (!more.empty()) list += (list.empty() ? "" : separator) + more;
  };
  for (const CLI::App* part : command.get_subcommands([](const CLI::App* sub) { return !sub->get_name().empty(); })) {
    const Words more = WordsOf(*part);
    add(words.options, part->get_name() + " " + more.options, " ");
    add(words.files, more.files, "|");
    add(words.valued, more.valued, "|");
  }
  return words;
}

std::string Cases(const Words& words, const std::string& indent) {
  std::string text;
  if (!words.files.empty())
    text += indent + words.files + ") mapfile -t COMPREPLY < <(compgen -f -- \"$word\"); return ;;\n";
  if (!words.valued.empty()) text += indent + words.valued + ") return ;;\n";
  return text.empty() ? text : indent.substr(2) + "case $before in\n" + text + indent.substr(2) + "esac\n";
}

}  // namespace

std::string BashCompletion(const CLI::App& app) {
  const std::string program = app.get_name();
  const auto commands = app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
  std::string names;
  std::string branches;
  for (const CLI::App* command : commands) {
    const Words words = WordsWithParts(*command);
    names += (names.empty() ? "" : " ") + command->get_name();
    branches +=
        "    " + command->get_name() + ")\n" + Cases(words, "        ") + "      offers='" + words.options + "' ;;\n";
  }
  const Words own = WordsOf(app);
  std::string text = "# Completion of " + program + " for bash.\n_" + program + "() {\n";
  text += "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command= offers= i\n";
  text +=
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    [[ ${COMP_WORDS[i]} == -* ]] || { command=${COMP_WORDS[i]}; break; }\n"
      "  done\n";
  text += "  COMPREPLY=()\n";
  if (commands.empty()) text += Cases(own, "    ") + "  offers='" + own.options + "'\n";
  if (!commands.empty())
    text += "  case $command in\n    '') offers='" + names + " " + own.options + "' ;;\n" + branches + "  esac\n";
  const std::string offer = "mapfile -t COMPREPLY < <(compgen -W \"$offers\" -- \"$word\")\n";
  if (commands.empty())
    text += "  " + offer;
  else
    text += "  if [[ -z $command || $word == -* ]]; then\n    " + offer +
            "  else\n    mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n  fi\n";
  return text + "}\ncomplete -o filenames -F _" + program + " " + program + "\n";
}

}  // namespace chequer
