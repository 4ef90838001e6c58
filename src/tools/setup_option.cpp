#include "tools/setup_option.h"

#include <fmt/format.h>

#include <cstdio>
#include <system_error>

namespace chequer {

CLI::Option* AddSetupOption(CLI::App& command, std::string& config, const std::string& supplies) {
  return command
      .add_option(
          "--config", config,
          fmt::format("Configuration of chequerd, or NAME for NAME.toml, here or in {}: supplies {} where the options "
                      "below do not [./{}, if it is there]",
                      kServiceFolder, supplies, kSetupHere))
      ->type_name("NAME|FILE");
}

std::optional<CameraSetup> LoadSetup(const std::string& typed) {
  if (!typed.empty()) return LoadCameraSetup(FindCameraSetup(typed));
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(kSetupHere, unknown)) return std::nullopt;
  fmt::print(stderr, "chequer: {} supplies what is not typed\n", kSetupHere);
  return LoadCameraSetup(kSetupHere);
}

std::filesystem::path FileOf(const char* option, const std::string& typed, const std::optional<CameraSetup>& setup,
                             const std::optional<std::filesystem::path>& in_setup, const char* key) {
  if (!typed.empty()) return typed;
  if (in_setup) return *in_setup;
  throw CLI::ValidationError(
      option, setup ? fmt::format("is missing, and {} does not name the file either ({})", setup->file.string(), key)
                    : fmt::format("is missing: name the file, or a configuration that does ({}) by --config", key));
}

}  // namespace chequer
