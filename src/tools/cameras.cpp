#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "capture/camera_list.h"
#include "core/printable.h"
#include "tools/commands.h"
#include "tools/message_json.h"

namespace chequer {
namespace {

struct CamerasRequest {
  bool json = false;
  bool all_features = false;
};

/// What devices say of themselves is text from outside.
template <typename... Arguments>
void Print(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  std::fputs(PrintableLines(fmt::format(format, std::forward<Arguments>(arguments)...)).c_str(), stdout);
}

std::string Rates(const std::vector<double>& rates_hz) {
  std::string text;
  for (const double rate : rates_hz) text += (text.empty() ? "" : ", ") + fmt::format("{:.4g}", rate);
  return text.empty() ? text : "  " + text + " fps";
}

void PrintFormats(const ListedCamera& camera) {
  for (const ListedFormat& format : camera.formats) {
    if (format.name.empty()) {
      Print("  {} cannot be used\n", format.native);
      continue;
    }
    Print("  pixel_format = \"{}\"  ({})\n", format.name, format.native);
    for (const ListedSize& size : format.sizes) Print("    {}{}\n", size.size, Rates(size.rates_hz));
  }
}

void PrintControls(const ListedCamera& camera) {
  if (camera.controls.empty()) return;
  Print("  [capture.{}]\n", camera.source == "v4l2" ? "controls" : "features");
  for (const ListedControl& control : camera.controls) {
    std::string text = control.allowed.empty() ? "can only be read" : control.allowed;
    if (!control.value.empty()) text += "; is " + control.value;
    if (!control.initial.empty() && control.initial != control.value) text += "; at first " + control.initial;
    if (control.is_inactive) text += "; governed by another now";
    Print("    {}: {}\n", control.name, text);
  }
}

void PrintCamera(const ListedCamera& camera) {
  Print("{}{}\n  source = \"{}\"\n  device = \"{}\"\n", camera.name,
        camera.serial.empty() ? "" : ", serial number " + camera.serial, camera.source, camera.device);
  for (const std::string& name : camera.also) Print("    also {}\n", name);
  if (!camera.problem.empty()) Print("  {}\n", camera.problem);
  PrintFormats(camera);
  PrintControls(camera);
}

Json ToJson(const ListedCamera& camera) {
  Json json;
  json["source"] = camera.source;
  json["device"] = camera.device;
  json["name"] = camera.name;
  json["serial"] = camera.serial;
  json["also"] = camera.also;
  json["problem"] = camera.problem;
  json["formats"] = Json::array();
  for (const ListedFormat& format : camera.formats) {
    Json sizes = Json::array();
    for (const ListedSize& size : format.sizes) sizes.push_back({{"size", size.size}, {"fps", size.rates_hz}});
    json["formats"].push_back({{"pixel_format", format.name}, {"native", format.native}, {"sizes", sizes}});
  }
  json["controls"] = Json::array();
  for (const ListedControl& control : camera.controls)
    json["controls"].push_back({{"name", control.name},
                                {"allowed", control.allowed},
                                {"value", control.value},
                                {"default", control.initial},
                                {"inactive", control.is_inactive}});
  return json;
}

void RunCameras(const CamerasRequest& request) {
  const std::vector<ListedCamera> cameras = ListCameras(request.all_features);
  for (const ListedCamera& camera : cameras) {
    if (request.json)
      std::printf("%s\n", Dump(ToJson(camera)).c_str());
    else
      PrintCamera(camera);
  }
  if (cameras.empty())
    std::fprintf(stderr,
                 "no camera was found: neither one of V4L2 (/dev/video0 and on) nor one that answers by GigE Vision or "
                 "USB3 Vision\n");
}

}  // namespace

void AddCamerasCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("cameras", "Lists the cameras that are there, and what they can do");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<CamerasRequest>();
  command->add_flag("--json", request->json, "One JSON object a line and camera");
  command->add_flag("--features", request->all_features, "All features of GenICam cameras, not the usual ones alone");
  command->footer(
      "What stands there can be copied into [capture] of a configuration. Asking the network takes a second.");
  command->callback([request] { RunCameras(*request); });
}

}  // namespace chequer
