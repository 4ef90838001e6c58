#include "capture/camera_config.h"

#include <array>
#include <string_view>
#include <utility>

#include "core/suggestion.h"

namespace chequer {
namespace {

template <typename Enum, std::size_t count>
using Words = std::array<std::pair<std::string_view, Enum>, count>;

constexpr std::size_t kMostSettings = 500;
constexpr NumberRange kFps{0.001, 10000};
constexpr IntegerRange kSide{1, kMaxImageSide};
constexpr IntegerRange kOffset{0, kMaxImageSide};
constexpr IntegerRange kBinning{1, 64};
constexpr Words<YuvRange, 2> kRanges{{{"full", YuvRange::kFull}, {"limited", YuvRange::kLimited}}};
constexpr Words<AutoMode, 3> kAutos{
    {{"off", AutoMode::kOff}, {"once", AutoMode::kOnce}, {"continuous", AutoMode::kContinuous}}};
constexpr Words<TriggerKind, 3> kTriggers{
    {{"free", TriggerKind::kFree}, {"software", TriggerKind::kSoftware}, {"hardware", TriggerKind::kHardware}}};

/// A key that may be left out.
template <typename Value, typename Limit>
void ReadOptional(TomlTable& table, std::string_view key, std::optional<Value>& value, const Limit& limit) {
  Value given{};
  if (table.Read(key, given, limit)) value = given;
}

void ReadSize(TomlTable& table, CameraOptions& camera) {
  ReadOptional(table, "width", camera.width, kSide);
  ReadOptional(table, "height", camera.height, kSide);
  if (camera.width.has_value() != camera.height.has_value())
    table.Fail(camera.width ? "height" : "width", "is missing: a size needs both sides");
}

void ReadFormat(TomlTable& table, CameraOptions& camera) {
  std::string name;
  if (!table.Read("pixel_format", name)) return;
  if (!ParsePixelFormat(name) && name != "MJPEG")
    table.Fail("pixel_format", "must be one of MJPEG, " + PixelFormatNames() +
                                   DidYouMean(name, WordsOf("MJPEG, " + PixelFormatNames())));
  camera.pixel_format = name;
}

}  // namespace

CameraOptions ReadCameraOptions(TomlTable& table, const char* settings) {
  CameraOptions camera;
  table.Read("device", camera.device);
  ReadFormat(table, camera);
  ReadSize(table, camera);
  table.Read("fps", camera.fps, kFps);
  table.Read("buffers", camera.buffers, IntegerRange{2, 32});
  double gamma = 0;
  if (table.Read("gamma", gamma, NumberRange{0.2, 5})) camera.tone_curve = ToneCurve::Gamma(gamma);
  for (TomlScalar& scalar : table.Table(settings).ReadScalars(kMostSettings))
    camera.settings.push_back({std::move(scalar.key), std::move(scalar.value), std::move(scalar.place)});
  camera.places = {table.Place("device"), table.Place("pixel_format"), table.Place("width"), table.Place("fps")};
  return camera;
}

V4l2Options ReadV4l2Options(TomlTable& table) {
  V4l2Options options;
  options.camera = ReadCameraOptions(table, "controls");
  ReadOptional(table, "yuv_range", options.yuv_range, kRanges);
  ReadOptional(table, "input", options.input, IntegerRange{0, 255});
  return options;
}

AravisOptions ReadAravisOptions(TomlTable& table) {
  AravisOptions options;
  options.camera = ReadCameraOptions(table, "features");
  if (options.camera.pixel_format == "MJPEG")
    table.Fail("pixel_format", "cameras of source = \"aravis\" give no JPEGs; must be one of " + PixelFormatNames());
  ReadOptional(table, "offset_x", options.offset_x, kOffset);
  ReadOptional(table, "offset_y", options.offset_y, kOffset);
  ReadOptional(table, "binning_x", options.binning_x, kBinning);
  ReadOptional(table, "binning_y", options.binning_y, kBinning);
  ReadOptional(table, "exposure_us", options.exposure_us, NumberRange{0.1, 1e9});
  ReadOptional(table, "exposure_auto", options.exposure_auto, kAutos);
  ReadOptional(table, "gain", options.gain, NumberRange{-100, 10000});
  ReadOptional(table, "gain_auto", options.gain_auto, kAutos);
  ReadOptional(table, "white_balance_auto", options.white_balance_auto, kAutos);
  ReadOptional(table, "balance_red", options.balance_red, NumberRange{0, 100});
  ReadOptional(table, "balance_blue", options.balance_blue, NumberRange{0, 100});
  table.Read("trigger", options.trigger, kTriggers);
  table.Read("trigger_line", options.trigger_line);
  table.Read("packet_size", options.packet_size, IntegerRange{0, 16384});
  table.Read("packet_resend", options.packet_resend);
  table.Read("ptp", options.ptp);
  return options;
}

}  // namespace chequer
