#include "capture/source_factory.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/aravis_source.h"
#include "capture/camera_config.h"
#include "capture/fault.h"
#include "capture/fault_source.h"
#include "capture/replay_source.h"
#include "capture/v4l2_source.h"

namespace chequer {
namespace {

template <typename Enum, std::size_t count>
using Words = std::array<std::pair<std::string_view, Enum>, count>;

constexpr Words<SourceKind, 3> kSources{
    {{"replay", SourceKind::kReplay}, {"v4l2", SourceKind::kV4l2}, {"aravis", SourceKind::kAravis}}};
constexpr Words<ReplayPace, 3> kPaces{
    {{"recorded", ReplayPace::kRecorded}, {"fixed", ReplayPace::kFixedRate}, {"unlimited", ReplayPace::kUnlimited}}};
constexpr Words<Preload, 3> kPreloads{{{"auto", Preload::kAuto}, {"yes", Preload::kYes}, {"no", Preload::kNo}}};
constexpr Words<ReplayTimes, 2> kTimes{{{"played", ReplayTimes::kPlayed}, {"recorded", ReplayTimes::kRecorded}}};
constexpr Words<PixelFormat, 5> kOneChannel{{{"Mono8", PixelFormat::kMono8},
                                             {"BayerRG8", PixelFormat::kBayerRg8},
                                             {"BayerGB8", PixelFormat::kBayerGb8},
                                             {"BayerGR8", PixelFormat::kBayerGr8},
                                             {"BayerBG8", PixelFormat::kBayerBg8}}};
constexpr NumberRange kFps{0.001, 10000};

void ReadPlainImages(TomlTable& table, PlainImageOptions& plain) {
  table.Read("fps", plain.fps, kFps);
  table.Read("one_channel", plain.one_channel, kOneChannel);
  double gamma = 0;
  if (table.Read("gamma", gamma, NumberRange{0.2, 5})) plain.tone_curve = ToneCurve::Gamma(gamma);
}

void ReadWhatToReplay(TomlTable& table, const std::filesystem::path& base, ReplayOptions& replay) {
  std::string path;
  std::vector<std::string> images;
  if (table.Read("path", path)) replay.path = base / path;
  table.Read("images", images, LengthRange{1, 100000});
  for (const std::string& image : images) replay.images.push_back(base / image);
  if (replay.path.empty() && images.empty())
    table.Fail("path", "is missing: must be a recording, a folder of images or one image; or give a list of images");
  if (!replay.path.empty() && !images.empty()) table.Fail("images", "must not be given beside path");
}

void ReadReplay(TomlTable& table, const std::filesystem::path& base, ReplayOptions& replay) {
  ReadWhatToReplay(table, base, replay);
  ReadPlainImages(table, replay.plain);
  table.Read("pace", replay.pace, kPaces);
  table.Read("replay_fps", replay.fps, kFps);
  table.Read("loop", replay.loop);
  table.Read("preload", replay.preload, kPreloads);
  std::uint64_t limit_mb = replay.preload_limit_bytes >> 20;
  table.Read("preload_limit_mb", limit_mb, IntegerRange{1, 65536});
  replay.preload_limit_bytes = limit_mb << 20;
  table.Read("times", replay.times, kTimes);
}

/// The keys that only some kinds of source have. config/chequerd.toml lists them by the same headings.
struct KeysOfSources {
  std::vector<SourceKind> sources;
  std::vector<std::string_view> keys;
};
const std::array<KeysOfSources, 4>& OwnKeys() {
  static const std::array<KeysOfSources, 4> own{
      {{{SourceKind::kReplay},
        {"path", "images", "one_channel", "pace", "replay_fps", "loop", "preload", "preload_limit_mb", "times"}},
       {{SourceKind::kV4l2, SourceKind::kAravis}, {"device", "pixel_format", "width", "height", "buffers"}},
       {{SourceKind::kV4l2}, {"yuv_range", "input", "controls"}},
       {{SourceKind::kAravis},
        {"offset_x", "offset_y", "binning_x", "binning_y", "exposure_us", "exposure_auto", "gain", "gain_auto",
         "white_balance_auto", "balance_red", "balance_blue", "trigger", "trigger_line", "packet_size", "packet_resend",
         "ptp", "features"}}}};
  return own;
}

std::string NameOf(SourceKind source) {
  for (const auto& [name, kind] : kSources)
    if (kind == source) return std::string("\"").append(name).append("\"");
  return {};
}

/// A key of another kind of source is no unknown key: it shows which source was meant.
void RefuseKeysOfOthers(const TomlTable& table, SourceKind source) {
  for (const auto& [sources, keys] : OwnKeys()) {
    if (std::find(sources.begin(), sources.end(), source) != sources.end()) continue;
    std::string theirs;
    for (const SourceKind kind : sources) theirs += (theirs.empty() ? "" : " or ") + NameOf(kind);
    for (const std::string_view key : keys)
      if (table.Has(key))
        table.FailUnknown(key, "with source = " + NameOf(source) +
                                   (table.Has("source") ? "" : ", which it is where none is named") +
                                   "; it is for source = " + theirs + ": name that source, or leave the key out");
  }
}

}  // namespace

CaptureOptions ReadCaptureOptions(TomlTable table, const std::filesystem::path& base) {
  CaptureOptions options;
  table.Read("source", options.source, kSources);
  RefuseKeysOfOthers(table, options.source);
  switch (options.source) {
    case SourceKind::kReplay: ReadReplay(table, base, options.replay); break;
    case SourceKind::kV4l2: options.v4l2 = ReadV4l2Options(table); break;
    case SourceKind::kAravis: options.aravis = ReadAravisOptions(table); break;
  }
  table.Read("faults", options.faults, LengthRange{0, 1000});
  try {
    ParseFaults(options.faults);
  } catch (const std::runtime_error& error) {
    table.Fail("faults", error.what());
  }
  return options;
}

const CameraOptions* CameraOf(const CaptureOptions& options) {
  switch (options.source) {
    case SourceKind::kV4l2: return &options.v4l2.camera;
    case SourceKind::kAravis: return &options.aravis.camera;
    case SourceKind::kReplay: break;
  }
  return nullptr;
}

CameraOptions* CameraOf(CaptureOptions& options) {
  return const_cast<CameraOptions*>(CameraOf(std::as_const(options)));
}

std::unique_ptr<FrameSource> MakeSource(const CaptureOptions& options, std::shared_ptr<WaitingClock> clock) {
  std::unique_ptr<FrameSource> source;
  switch (options.source) {
    case SourceKind::kReplay: source = std::make_unique<ReplaySource>(options.replay, clock); break;
    case SourceKind::kV4l2: source = std::make_unique<V4l2Source>(options.v4l2); break;
    case SourceKind::kAravis: source = std::make_unique<AravisSource>(options.aravis); break;
  }
  if (options.faults.empty()) return source;
  return std::make_unique<FaultSource>(std::move(source), ParseFaults(options.faults), std::move(clock));
}

std::unique_ptr<FrameSource> MakeSource(const CaptureOptions& options) {
  return MakeSource(options, MakeSystemClock());
}

void CheckRecording(const CaptureOptions& options) {
  if (options.source != SourceKind::kReplay) return;
  ReplayOptions replay = options.replay;
  replay.preload = Preload::kNo;
  if (const std::string wrong = ReplaySource(replay, MakeSystemClock()).Open(); !wrong.empty())
    throw std::runtime_error(wrong);
}

}  // namespace chequer
