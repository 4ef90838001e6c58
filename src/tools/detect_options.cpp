#include "tools/detect_options.h"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "chequer/camera_file.h"
#include "core/suggestion.h"
#include "robot/robot_roster.h"
#include "setup/print_table.h"
#include "tools/setup_option.h"

namespace chequer {
namespace {

constexpr std::string_view kOneChannelFormats = "Mono8, BayerRG8, BayerGB8, BayerGR8, BayerBG8";

ColorSpace ChooseColorSpace(const std::string& name, const std::optional<CameraSetup>& setup) {
  if (name.empty()) return setup ? setup->color_space : ColorSpace::kLab;
  if (name == "lab") return ColorSpace::kLab;
  if (name == "hsv") return ColorSpace::kHsv;
  throw CLI::ValidationError(
      "--color-space", "'" + name + "' is not known; it must be lab or hsv" + DidYouMean(name, WordsOf("lab, hsv")));
}

PrintTolerance ChoosePrintTolerance(const std::string& typed, const std::optional<CameraSetup>& setup) {
  if (typed.empty()) return setup ? setup->print_tolerance : PrintTolerance{};
  const auto tolerance = ParsePrintTolerance(typed);
  if (!tolerance)
    throw CLI::ValidationError(
        "--print-tolerance",
        fmt::format("'{}' is not known; it must be {}, at most 0.05 and 5mm", typed, kPrintToleranceForms));
  return *tolerance;
}

/// Gives the configuration's families the prints that its roster measures.
void TakePrints(const DetectOptions& request, std::vector<MarkerFamily>& families) {
  const auto& setup = request.setup;
  std::error_code unknown;
  const bool typed = request.markers.names_kind || request.markers.side_m;
  if (typed || !setup || !setup->robots || !std::filesystem::exists(*setup->robots, unknown)) return;
  SetPrints(LoadRobotRoster(*setup->robots, families), families);
}

}  // namespace

PixelFormat ParseOneChannel(const std::string& name) {
  const auto format = ParsePixelFormat(name);
  if (!format || (*format != PixelFormat::kMono8 && !IsBayer(*format)))
    throw CLI::ValidationError("--pixel-format",
                               UnknownWord("what a one-channel file can hold", name, WordsOf(kOneChannelFormats)));
  return *format;
}

std::optional<ToneCurve> ParseGamma(std::optional<double> gamma) {
  if (!gamma) return std::nullopt;
  if (!(*gamma >= 0.2 && *gamma <= 5))
    throw CLI::ValidationError("--gamma", fmt::format("{} is outside 0.2 to 5; 1 is linear", *gamma));
  return ToneCurve::Gamma(*gamma);
}

void CheckRange(const char* option, int value, int least, int most) {
  if (value < least || value > most)
    throw CLI::ValidationError(option, fmt::format("{} is outside {} to {}", value, least, most));
}

void TakeSetup(DetectOptions& options, const char* command) {
  options.setup = LoadSetup(options.config);
  if (!options.setup || !options.setup->calibration || !options.calibration.empty()) return;
  const std::filesystem::path& calibration = *options.setup->calibration;
  std::error_code unknown;
  if (std::filesystem::exists(calibration, unknown))
    options.calibration = calibration.string();
  else
    fmt::print(stderr, "chequer {}: {} is not there yet, so poses are left out; `chequer calibrate lens` makes it\n",
               command, calibration.string());
}

DetectorOptions MakeDetectorOptions(const DetectOptions& request) {
  CheckRange("--threads", request.threads, 1, 64);
  DetectorOptions options;
  options.families = ChooseMarkerFamilies(request.markers, request.setup, !request.calibration.empty());
  if (!request.calibration.empty()) TakePrints(request, options.families);
  options.color_space = ChooseColorSpace(request.color_space, request.setup);
  options.print_tolerance = ChoosePrintTolerance(request.print_tolerance, request.setup);
  options.threads = request.threads;
  if (!request.calibration.empty()) options.camera = LoadCamera(request.calibration);
  // What is typed goes before what was measured.
  if (request.gamma && options.camera) options.camera->tone_curve.reset();
  return options;
}

ImageView WithToneCurve(const ImageView& image, const std::optional<ToneCurve>& curve) {
  if (!curve) return image;
  const Plane planes[] = {image.plane(0), image.plane(1), image.plane(2)};
  return ImageView(image.format(), image.width(), image.height(), planes, *curve, image.yuv_range());
}

void CheckCalibrationFits(const DetectorOptions& detector, const DetectOptions& options, const std::string& name,
                          const ImageView& image) {
  const auto& camera = detector.camera;
  if (camera && (camera->width != image.width() || camera->height != image.height()))
    throw std::runtime_error(fmt::format(
        "{}: the image is {}x{}, but the calibration {} is for {}x{}; give the one of this camera at this size", name,
        image.width(), image.height(), options.calibration, camera->width, camera->height));
}

void AddDetectOptions(CLI::App& command, DetectOptions& request) {
  AddSetupOption(command, request.config, "camera file, markers and the sides of the roster");
  AddMarkerOptions(command, request.markers);
  command.add_option("--calibration", request.calibration, "Camera file; without it poses are left out")
      ->type_name("FILE");
  command
      .add_option("--pixel-format", request.pixel_format,
                  "What one-channel files hold: Mono8, BayerRG8, BayerGB8, BayerGR8, BayerBG8")
      ->type_name("FORMAT")
      ->capture_default_str();
  command.add_option("--gamma", request.gamma, "Curve of the values, 1 is linear; without it sRGB, or the recording's")
      ->type_name("G");
  command
      .add_option("--print-tolerance", request.print_tolerance,
                  fmt::format("How far prints may be off, and focal lengths that state no error to 0.0001: {} [none]",
                              kPrintToleranceForms))
      ->type_name("KIND");
  command.add_option("--color-space", request.color_space, "Where saturation is told from: lab or hsv [lab]")
      ->type_name("SPACE");
}

}  // namespace chequer
