#include "daemon/config.h"

#include <array>
#include <functional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "chequer/camera_file.h"
#include "core/file.h"
#include "core/length.h"
#include "core/number_text.h"
#include "core/tone_distance.h"
#include "publish/channels.h"
#include "publish/lcm_url.h"
#include "setup/marker_table.h"
#include "setup/print_table.h"

namespace chequer {
namespace {

template <typename Enum, std::size_t count>
using Words = std::array<std::pair<std::string_view, Enum>, count>;

constexpr Words<ColorSpace, 2> kColorSpaces{{{"lab", ColorSpace::kLab}, {"hsv", ColorSpace::kHsv}}};
constexpr Words<WhenBusyChoice, 3> kWhenBusy{
    {{"auto", WhenBusyChoice::kAuto}, {"newest", WhenBusyChoice::kNewest}, {"wait", WhenBusyChoice::kWait}}};
constexpr Words<LogLevel, 4> kLevels{{{"debug", LogLevel::kDebug},
                                      {"info", LogLevel::kInfo},
                                      {"warning", LogLevel::kWarning},
                                      {"error", LogLevel::kError}}};
constexpr Words<LogTarget, 3> kTargets{
    {{"auto", LogTarget::kAuto}, {"console", LogTarget::kConsole}, {"journal", LogTarget::kJournal}}};
constexpr Words<BudgetChoice, 2> kBudgets{{{"auto", BudgetChoice::kAuto}, {"unlimited", BudgetChoice::kUnlimited}}};
constexpr Words<ThreadsChoice, 1> kThreads{{{"auto", ThreadsChoice::kAuto}}};
constexpr IntegerRange kBudgetUnits{kLeastBudget, 1'000'000'000};
constexpr NumberRange kOverlap{0, 0.5};
constexpr NumberRange kCarry{0, 60};
constexpr std::size_t kMaxFamilies = 64;
constexpr std::size_t kMaxNotedBytes = 64u << 20;

/// Turns what `read` throws into a message with the place of the key.
template <typename Read>
auto AtKey(const TomlTable& table, std::string_view key, Read&& read) {
  try {
    return std::forward<Read>(read)();
  } catch (const std::runtime_error& error) {
    table.Fail(key, error.what());
  }
}

/// Keeps what the file says that a key names, for ChangedSections. To be called before the file is read: then a change
/// in between is reported twice at worst, never lost.
void NoteFile(const std::filesystem::path& file, const std::string& section, DaemonConfig& config) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(file, unknown)) return;
  try {
    const std::size_t hash = std::hash<std::string>{}(ReadFile(file, kMaxNotedBytes));
    config.sections[section] += "\n" + file.string() + " " + std::to_string(hash);
  } catch (const std::runtime_error&) {
    // Whoever reads it next says what is wrong with it, and names the key.
  }
}

void ReadCamera(TomlTable table, const std::filesystem::path& base, DaemonConfig& config) {
  if (table.Read("name", config.camera_name, LengthRange{1, kMaxCameraName}) && !IsValidPrefix(config.camera_name))
    table.Fail("name", "must be of the characters A-Z a-z 0-9 _ -, because it is part of LCM channels");
  std::string calibration;
  if (!table.Read("calibration", calibration)) return;
  NoteFile(base / calibration, "camera", config);
  config.detector.camera = AtKey(table, "calibration", [&] { return LoadCamera(base / calibration); });
}

/// A camera whose size is left out is asked for the one that its calibration is for.
void TakeSizeOfCalibration(DaemonConfig& config) {
  CameraOptions* camera = CameraOf(config.capture);
  if (camera == nullptr || camera->width || !config.detector.camera) return;
  camera->width = config.detector.camera->width;
  camera->height = config.detector.camera->height;
}

/// What the configuration says of the curve of the values, where it was measured and is another.
void CheckToneCurve(TomlTable capture, DaemonConfig& config) {
  constexpr double kFits = 0.015;  // calibrate lens tells no smaller difference
  if (!capture.Has("gamma") || !config.detector.camera || !config.detector.camera->tone_curve) return;
  const CameraOptions* camera = CameraOf(config.capture);
  const ToneCurve& stated = camera != nullptr ? camera->tone_curve : config.capture.replay.plain.tone_curve;
  const ToneCurve& measured = *config.detector.camera->tone_curve;
  if (ToneDistance(stated, measured) > kFits)
    config.remarks.push_back(capture.Place("gamma") + ": does not fit the camera; its file has " + measured.Name() +
                             ", as calibrate lens measured it, and that is taken");
}

void ReadDetect(TomlTable table, DaemonConfig& config) {
  DetectorOptions& detector = config.detector;
  table.Read("color_space", detector.color_space, kColorSpaces);
  table.Read("max_luminance_overlap", detector.max_luminance_overlap, kOverlap);
  table.Read("max_saturation_overlap", detector.max_saturation_overlap, kOverlap);
  std::uint64_t threads = 1;
  table.Read("threads", config.threads, kThreads, ThreadsChoice::kNumber, threads, IntegerRange{1, 64});
  detector.threads = static_cast<int>(threads);
  table.Read("memory", config.memory);
  table.Read("search_every", detector.search_every, IntegerRange{1, 64});
  table.Read("carry_s", detector.carry_s, kCarry);
  table.Read("learn_levels", detector.learn_levels);
  table.Read("budget", config.budget.choice, kBudgets, BudgetChoice::kUnits, config.budget.units, kBudgetUnits);
}

void ReadMarkers(TomlTable& root, const std::filesystem::path& base, DaemonConfig& config) {
  DetectorOptions& detector = config.detector;
  std::vector<TomlTable> tables = root.Tables("marker", kMaxFamilies);
  if (tables.empty())
    root.Fail("marker", "is missing: at least one [[marker]] with size, variant and side must say what is sought");
  detector.families.clear();
  for (TomlTable& table : tables) {
    if (std::string file; table.Read("table", file)) NoteFile(base / file, "marker", config);
    detector.families.push_back(ReadMarkerFamily(table, base, detector.camera.has_value()));
    const std::string hint = DidYouMeanMillimetres(RoundText(detector.families.back().side_m));
    if (!hint.empty()) config.remarks.push_back(table.Place("side") + ": is large for a marker" + hint);
  }
}

void ReadPipeline(TomlTable table, DaemonConfig& config) {
  table.Read("workers", config.workers, IntegerRange{0, 64});
  table.Read("when_busy", config.when_busy, kWhenBusy);
  std::vector<std::int64_t> cpus;
  table.Read("cpus", cpus, LengthRange{1, 64}, IntegerRange{0, 1023});
  config.scheduling.cpus.assign(cpus.begin(), cpus.end());
  table.Read("realtime_priority", config.scheduling.realtime_priority, IntegerRange{0, 98});
}

void ReadMetrics(TomlTable table, const std::filesystem::path& base, MetricsOptions& metrics) {
  std::int64_t port = 0;
  table.Read("port", port, IntegerRange{0, 65535});
  metrics.port = static_cast<std::uint16_t>(port);
  std::string file;
  if (!table.Read("file", file)) return;
  metrics.file = base / file;
  if (metrics.file.extension() != ".prom") table.Fail("file", "must end in .prom, or the node exporter passes it over");
}

void ReadPublish(TomlTable table, DaemonConfig& config) {
  LcmPublisherOptions& publish = config.publish;
  publish.prefix = DefaultPrefix(config.camera_name);
  table.Read("url", publish.url);
  const LcmUrl url = AtKey(table, "url", [&] { return ParseLcmUrl(publish.url, LcmDirection::kPublish); });
  if (url.LeavesTheHost())
    config.remarks.push_back(table.Place("url") +
                             ": the messages leave this host, and whoever can send to that group can forge them; the "
                             "service's sandbox does not keep them here (chequerd(8), SECURITY)");
  if (!table.Read("prefix", publish.prefix, LengthRange{1, kMaxPrefixLength})) return;
  if (const std::string wrong = publish.Check(); !wrong.empty()) table.Fail("prefix", wrong);
}

/// Reads [view]. @pre [publish] is read.
void ReadView(TomlTable table, DaemonConfig& config) {
  const LcmUrl url = ParseLcmUrl(config.publish.url, LcmDirection::kPublish);
  const bool multicast = url.provider == LcmProvider::kUdpMulticast;
  const bool fits = config.publish.prefix.size() <= kMaxViewedPrefix;
  config.allow_view = multicast && fits && !url.LeavesTheHost();
  if (bool allow = false; table.Read("allow", allow)) {
    if (allow && !fits)
      table.Fail("allow", "cannot be true with a channel prefix of more than " + std::to_string(kMaxViewedPrefix) +
                              " characters");
    config.allow_view = allow && multicast;
    if (allow && url.LeavesTheHost())
      config.remarks.push_back(table.Place("allow") +
                               ": whoever can send to the group can ask for pictures, which then leave this host");
  }
}

DaemonConfig ReadConfig(TomlFile& file, const std::filesystem::path& base, const std::string& camera_name) {
  DaemonConfig config;
  config.camera_name = camera_name;
  TomlTable root = file.root();
  ReadCamera(root.Table("camera"), base, config);
  config.capture = ReadCaptureOptions(root.Table("capture"), base);
  TakeSizeOfCalibration(config);
  CheckToneCurve(root.Table("capture"), config);
  ReadDetect(root.Table("detect"), config);
  ReadMarkers(root, base, config);
  config.detector.print_tolerance = ReadPrintTolerance(root.Table("print"));
  for (const char* section : {"world", "robots"})
    if (std::string name; root.Table(section).Read("file", name)) NoteFile(base / name, section, config);
  ReadFrameTables(root, base, config);
  ReadPipeline(root.Table("pipeline"), config);
  ReadPublish(root.Table("publish"), config);
  ReadView(root.Table("view"), config);
  ReadMetrics(root.Table("metrics"), base, config.metrics);
  TomlTable log = root.Table("log");
  log.Read("level", config.log.level, kLevels);
  log.Read("target", config.log.target, kTargets);
  file.CheckAllKeysRead();
  for (const auto& [name, text] : root.Texts()) config.sections[name].insert(0, text);
  return config;
}

}  // namespace

DaemonConfig LoadDaemonConfig(const std::filesystem::path& path) {
  TomlFile file = TomlFile::Load(path);
  return ReadConfig(file, path.parent_path(), CameraNameOf(path));
}

DaemonConfig ParseDaemonConfig(std::string_view text, const std::string& name, const std::filesystem::path& base) {
  TomlFile file = TomlFile::Parse(text, name);
  return ReadConfig(file, base, DaemonConfig().camera_name);
}

}  // namespace chequer
