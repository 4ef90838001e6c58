#include "tools/calibrate.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <ctime>
#include <string_view>
#include <system_error>

#include "core/output_file.h"
#include "core/set_aside.h"
#include "tools/commands.h"

namespace chequer {

namespace {

constexpr std::size_t kMaxCalibrationBytes = 16u << 20;

/// The comment below a text; it changes with the text (FNV-1a).
std::string Seal(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3;
  return fmt::format("# Not edited since chequer wrote it: {:016x}\n", hash);
}

}  // namespace

bool IsEdited(const std::filesystem::path& file) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(file, unknown)) return false;
  const std::string text = ReadFile(file, kMaxCalibrationBytes);
  if (text.empty()) return false;
  const std::size_t seal_bytes = Seal({}).size();
  if (text.size() < seal_bytes) return true;
  const std::string_view body = std::string_view(text).substr(0, text.size() - seal_bytes);
  return text.substr(body.size()) != Seal(body);
}

void CheckFolderOf(const char* option, const std::filesystem::path& file) {
  if (const std::string why = WhyNotWritable(file); !why.empty())
    throw CLI::ValidationError(option, "'" + file.string() + "' cannot be written: " + why);
}

void CheckPngName(const char* option, const std::filesystem::path& file) {
  CheckFolderOf(option, file);
  if (file.extension() != ".png") throw CLI::ValidationError(option, "'" + file.string() + "' must end in .png");
}

void CheckOut(const std::filesystem::path& file, bool force) {
  CheckFolderOf("--out", file);
  if (force || !IsEdited(file)) return;
  throw CLI::ValidationError(
      "--out",
      "'" + file.string() + "' was edited, or not written by this command, and would be lost; --force replaces it");
}

void WriteCalibration(const std::filesystem::path& file, const std::string& text) {
  if (IsEdited(file))
    fmt::print("the edited {} is kept as {}\n", file.string(), KeepAside(ThroughLinks(file)).string());
  WriteFileAtomically(file, text + Seal(text));
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
