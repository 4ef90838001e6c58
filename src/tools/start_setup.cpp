#include "tools/start_setup.h"

#include <fmt/format.h>

#include <string_view>

#include "core/file.h"
#include "core/toml_reader.h"

namespace chequer {
namespace {

std::string TomlText(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string CaptureTable(const StartAnswers& answers) {
  if (!answers.recording.empty())
    return fmt::format("source = \"replay\"\npath = {}\nloop = true\n",
                       TomlText(std::filesystem::absolute(answers.recording).string()));
  const bool genicam = !answers.device.empty() && answers.device.front() != '/';
  std::string text = fmt::format("source = \"{}\"\n", genicam ? "aravis" : "v4l2");
  if (!answers.device.empty()) text += "device = " + TomlText(answers.device) + "\n";
  return text;
}

}  // namespace

std::string CalibrationLine(const StartAnswers& answers) {
  return fmt::format("calibration = {}\n", TomlText(answers.File("camera.toml").filename().string()));
}

std::string WorldLine(const StartAnswers& answers) {
  return fmt::format("file = {}\n", TomlText(answers.File("world.toml").filename().string()));
}

std::string RobotsLine(const StartAnswers& answers) {
  return fmt::format("file = {}\n", TomlText(answers.File("robots.toml").filename().string()));
}

std::string StartConfiguration(const StartAnswers& answers) {
  return fmt::format(
      "# The camera {0}, as `chequer start` began it; chequerd.toml(5) has every key. Lines that begin with # wait for "
      "their\n# step: lens, world, robots.\n\n"
      "[camera]\nname = {1}\n#{2}\n[capture]\n{3}\n"
      "[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = {4}\n"
      "# Robots have 0 to {5}; {6} to {7} lie on the floor: the corner, on the x axis, on the y axis.\n"
      "roster = [\"0-{7}\"]\n\n[world]\n#{8}\n[robots]\n#{9}\n[tracks]\nenabled = true\n",
      answers.name, TomlText(answers.name), CalibrationLine(answers), CaptureTable(answers), TomlText(answers.side),
      answers.robots - 1, answers.robots, answers.robots + kFloorMarkers - 1, WorldLine(answers), RobotsLine(answers));
}

bool SwitchOn(const std::filesystem::path& config, const std::string& line) {
  std::string text = ReadFile(config, kMaxTomlBytes);
  const std::size_t at = text.find("\n#" + line);
  if (at == std::string::npos) return false;
  text.erase(at + 1, 1);
  WriteFileAtomically(config, text);
  return true;
}

}  // namespace chequer
