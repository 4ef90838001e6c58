#include "tools/setup_option.h"

#include <fmt/format.h>

#include <cstdio>
#include <system_error>

#include "publish/channels.h"
#include "publish/lcm_subscriber.h"
#include "publish/lcm_url.h"

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

void AddListenUrlOption(CLI::App& command, std::string& url) {
  command
      .add_option("--url", url,
                  "LCM URL [the configuration's, else the environment's LCM_DEFAULT_URL, else " +
                      ListenUrlFor(std::string(kDefaultLcmUrl)) + "]")
      ->type_name("URL");
}

std::optional<CameraSetup> LoadSetup(const std::string& typed) {
  if (!typed.empty()) return LoadCameraSetup(FindCameraSetup(typed));
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(kSetupHere, unknown)) return std::nullopt;
  fmt::print(stderr, "chequer: {} supplies what is not typed\n", kSetupHere);
  return LoadCameraSetup(kSetupHere);
}

std::string CameraNameIn(const CameraSetup& setup) {
  return setup.camera_name.empty() ? CameraNameOf(setup.file) : setup.camera_name;
}

std::string PrefixIn(const CameraSetup& setup) {
  return setup.publish_prefix.value_or(DefaultPrefix(CameraNameIn(setup)));
}

std::string ListenUrlIn(const CameraSetup& setup) {
  return ListenUrlFor(setup.publish_url.value_or(std::string(kDefaultLcmUrl)));
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
