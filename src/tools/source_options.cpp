#include "tools/source_options.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "chequer/camera_file.h"
#include "core/number_text.h"
#include "core/suggestion.h"
#include "core/toml_reader.h"
#include "publish/channels.h"
#include "tools/setup_option.h"

namespace chequer {
namespace {

/// A text as TOML writes it.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;  // no name has them
  }
  return quoted + "\"";
}

/// A text that is a number to its end.
template <typename Number>
std::optional<Number> ReadNumber(const std::string& typed) {
  Number number = 0;
  const auto [end, error] = std::from_chars(typed.data(), typed.data() + typed.size(), number);
  if (error != std::errc() || end != typed.data() + typed.size()) return std::nullopt;
  return number;
}

/// As TOML writes it, which neither knows .5 nor takes 7 for 7.0.
std::string Decimal(double number) {
  const std::string written = ExactText(number);
  return written.find_first_of(".e") == std::string::npos ? written + ".0" : written;
}

/// Numbers, true and false as such, all else as a text.
std::string TomlValue(const std::string& typed) {
  if (typed == "true" || typed == "false") return typed;
  if (const auto whole = ReadNumber<std::int64_t>(typed)) return std::to_string(*whole);
  const auto number = ReadNumber<double>(typed);
  return number && std::isfinite(*number) ? Decimal(*number) : Quoted(typed);
}

std::string SourceOf(const SourceRequest& request) {
  if (!request.source.empty()) return request.source;
  return request.device.empty() || request.device.starts_with('/') ? "v4l2" : "aravis";
}

std::string SettingLine(const std::string& setting) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    throw CLI::ValidationError("--set", "'" + setting + "' must be NAME=VALUE, such as brightness=128");
  return Quoted(setting.substr(0, equals)) + " = " + TomlValue(setting.substr(equals + 1)) + "\n";
}

std::string SizeLines(const std::string& size) {
  const std::size_t times = size.find('x');
  const std::string width = size.substr(0, times), height = times == std::string::npos ? "" : size.substr(times + 1);
  const auto is_number = [](const std::string& text) {
    return !text.empty() && text.size() < 6 && text.find_first_not_of("0123456789") == std::string::npos;
  };
  if (!is_number(width) || !is_number(height))
    throw CLI::ValidationError("--size", "'" + size + "' must be WIDTHxHEIGHT in pixels, such as 1920x1080");
  return "width = " + width + "\nheight = " + height + "\n";
}

}  // namespace

std::string CaptureText(const SourceRequest& request) {
  const std::string source = SourceOf(request);
  std::string text = "[capture]\nsource = " + Quoted(source) + "\n";
  if (!request.device.empty()) text += "device = " + Quoted(request.device) + "\n";
  if (!request.pixel_format.empty()) text += "pixel_format = " + Quoted(request.pixel_format) + "\n";
  if (!request.size.empty()) text += SizeLines(request.size);
  if (request.fps) text += "fps = " + Decimal(*request.fps) + "\n";
  if (!request.settings.empty()) text += source == "v4l2" ? "[capture.controls]\n" : "[capture.features]\n";
  for (const std::string& setting : request.settings) text += SettingLine(setting);
  return text;
}

void AddSourceOptions(CLI::App& command, SourceRequest& request) {
  const char* group = "Where the frames come from";
  AddSetupOption(command, request.config, "the camera and its file")->group(group);
  command
      .add_option("--device", request.device,
                  "Node, name or serial number of a V4L2 camera; id, serial number or address of a GenICam camera; "
                  "`chequer cameras` lists them [the only V4L2 camera]")
      ->type_name("CAMERA")
      ->group(group);
  command.add_option("--source", request.source, "v4l2 or aravis [v4l2 if the device begins with /]")
      ->type_name("KIND")
      ->group(group);
  command.add_option("--pixel-format", request.pixel_format, "[the best there is]")->type_name("F")->group(group);
  command.add_option("--size", request.size, "[the largest that is fast enough]")->type_name("WxH")->group(group);
  command.add_option("--fps", request.fps, "[30]")->group(group);
  command.add_option("--set", request.settings, "A control or feature, such as brightness=128; may be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(group);
  command.add_option("--calibration", request.calibration, "Camera file [the configuration's]")
      ->type_name("FILE")
      ->group(group);
}

ChosenSource ChooseSource(const SourceRequest& request) {
  const bool has_own = !request.device.empty() || !request.source.empty() || !request.pixel_format.empty() ||
                       !request.size.empty() || request.fps || !request.settings.empty();
  if (!request.config.empty() && has_own)
    throw CLI::ValidationError("--config",
                               "says it all: leave out --device, --source, --pixel-format, --size, --fps "
                               "and --set");
  if (!request.source.empty() && request.source != "v4l2" && request.source != "aravis")
    throw CLI::ValidationError(
        "--source", "'" + request.source + "' must be v4l2 or aravis; other sources need a configuration (--config)" +
                        DidYouMean(request.source, WordsOf("v4l2, aravis")));
  ChosenSource chosen;
  const auto setup = has_own ? std::nullopt : LoadSetup(request.config);
  if (setup && setup->capture) {
    chosen.camera = CameraNameIn(*setup);
    // Before the lens is calibrated it is not there yet.
    std::error_code unknown;
    if (setup->calibration && std::filesystem::exists(*setup->calibration, unknown))
      chosen.calibration = setup->calibration;
    chosen.capture = *setup->capture;
  } else if (!request.config.empty()) {
    throw std::runtime_error(setup->file.string() + ": a table [capture] must say where frames come from");
  } else {
    TomlFile file = TomlFile::Parse(CaptureText(request), "");
    chosen.capture = ReadCaptureOptions(file.root().Table("capture"), {});
    file.CheckAllKeysRead();
  }
  if (!request.calibration.empty()) chosen.calibration = request.calibration;
  CameraOptions* camera = CameraOf(chosen.capture);
  if (camera != nullptr && !camera->width && chosen.calibration) {
    const CameraModel model = LoadCamera(*chosen.calibration);
    camera->width = model.width;
    camera->height = model.height;
  }
  return chosen;
}

std::unique_ptr<FrameSource> OpenSource(const ChosenSource& chosen, const char* command) {
  std::unique_ptr<FrameSource> source = MakeSource(chosen.capture);
  if (const std::string problem = source->Open(); !problem.empty()) throw std::runtime_error(problem);
  for (const std::string& remark : source->Remarks()) std::fprintf(stderr, "chequer %s: %s\n", command, remark.c_str());
  return source;
}

}  // namespace chequer
