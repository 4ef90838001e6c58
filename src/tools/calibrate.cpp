#include "tools/calibrate.h"

#include <unistd.h>

#include <array>
#include <ctime>

#include "tools/commands.h"

namespace chequer {

void CheckFolderOf(const char* option, const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw CLI::ValidationError(
        option, "'" + file.string() + "' cannot be written: there is no folder " + folder.string() + " that lets you");
}

std::string NowInUtc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

void AddCalibrateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("calibrate", "Calibrates the lens of a camera, where it stands, and robots");
  command->require_subcommand(1);
  AddCalibrateLensCommand(*command);
  AddCalibrateWorldCommand(*command);
  AddCalibrateRobotsCommand(*command);
}

}  // namespace chequer
