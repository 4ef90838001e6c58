#include "tools/calibrate.h"

#include <array>
#include <ctime>

#include "tools/commands.h"

namespace chequer {

std::string NowInUtc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

void AddCalibrateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("calibrate", "Calibrates the lens of a camera, and where it stands");
  command->require_subcommand(1);
  AddCalibrateLensCommand(*command);
  AddCalibrateWorldCommand(*command);
}

}  // namespace chequer
