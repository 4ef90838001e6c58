#include "manual/completion.h"

#include <CLI/CLI.hpp>
#include <vector>

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

std::string Cases(const Words& words, const std::string& indent) {
  std::string text;
  if (!words.files.empty())
    text += indent + words.files + ") mapfile -t COMPREPLY < <(compgen -f -- \"$word\"); return ;;\n";
  if (!words.valued.empty()) text += indent + words.valued + ") return ;;\n";
  return text.empty() ? text : indent.substr(2) + "case $before in\n" + text + indent.substr(2) + "esac\n";
}

std::vector<const CLI::App*> CommandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

bool TakesArguments(const CLI::App& app) {
  return !app.get_options([](const CLI::Option* option) { return option->get_positional(); }).empty();
}

/// What may follow a command, a branch for it and for each command below it; and the patterns that tell how the path to
/// a command grows by a word.
struct Branches {
  std::string text;
  std::string steps;
};

void AddBranches(const CLI::App& app, const std::string& path, Branches& branches) {
  const Words words = WordsOf(app);
  std::string offers;
  for (const CLI::App* command : CommandsOf(app)) {
    offers += command->get_name() + " ";
    branches.steps += (branches.steps.empty() ? "'" : "|'") + path + " " + command->get_name() + "'";
  }
  branches.text += "    '" + path + "')\n" + Cases(words, "        ") + "      offers='" + offers + words.options +
                   "'" + (TakesArguments(app) ? " files=yes" : "") + " ;;\n";
  for (const CLI::App* command : CommandsOf(app))
    AddBranches(*command, path.empty() ? command->get_name() : path + " " + command->get_name(), branches);
}

}  // namespace

std::string BashCompletion(const CLI::App& app) {
  const std::string program = app.get_name();
  Branches branches;
  AddBranches(app, "", branches);
  std::string text = "# Completion of " + program + " for bash.\n_" + program + "() {\n";
  text += "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command= offers= files= i\n";
  if (!branches.steps.empty())
    text +=
        "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
        "    case \"$command ${COMP_WORDS[i]}\" in\n      " +
        branches.steps +
        ") command=${command:+$command }${COMP_WORDS[i]} ;;\n"
        "    esac\n"
        "  done\n";
  text += "  COMPREPLY=()\n  case $command in\n" + branches.text + "  esac\n";
  text +=
      "  if [[ -z $files || $word == -* ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$offers\" -- \"$word\")\n"
      "  else\n"
      "    mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
      "  fi\n";
  return text + "}\ncomplete -o filenames -F _" + program + " " + program + "\n";
}

}  // namespace chequer
