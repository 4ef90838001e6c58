#include "daemon/config.h"

#include <array>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "chequer/camera_file.h"
#include "publish/channels.h"
#include "publish/lcm_url.h"

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
constexpr NumberRange kOverlap{0, 0.5};
constexpr std::size_t kMaxFamilies = 64;

/// Turns what `read` throws into a message with the place of the key.
template <typename Read>
auto AtKey(const TomlTable& table, std::string_view key, Read&& read) {
  try {
    return std::forward<Read>(read)();
  } catch (const std::runtime_error& error) {
    table.Fail(key, error.what());
  }
}

void ReadCamera(TomlTable table, const std::filesystem::path& base, DaemonConfig& config) {
  const std::size_t longest = kMaxPrefixLength - DefaultPrefix({}).size();
  if (table.Read("name", config.camera_name, LengthRange{1, longest}) && !IsValidPrefix(config.camera_name))
    table.Fail("name", "must be of the characters A-Z a-z 0-9 _ -, because it is part of LCM channels");
  std::string calibration;
  if (table.Read("calibration", calibration))
    config.detector.camera = AtKey(table, "calibration", [&] { return LoadCamera(base / calibration); });
}

/// A camera whose size is left out is asked for the one that its calibration is for.
void TakeSizeOfCalibration(DaemonConfig& config) {
  CameraOptions* camera = CameraOf(config.capture);
  if (camera == nullptr || camera->width || !config.detector.camera) return;
  camera->width = config.detector.camera->width;
  camera->height = config.detector.camera->height;
}

void ReadDetect(TomlTable table, DetectorOptions& detector) {
  table.Read("color_space", detector.color_space, kColorSpaces);
  table.Read("max_luminance_overlap", detector.max_luminance_overlap, kOverlap);
  table.Read("max_saturation_overlap", detector.max_saturation_overlap, kOverlap);
  table.Read("threads", detector.threads, IntegerRange{1, 64});
}

void ReadMarkers(TomlTable& root, const std::filesystem::path& base, DetectorOptions& detector) {
  std::vector<TomlTable> tables = root.Tables("marker", kMaxFamilies);
  if (tables.empty())
    root.Fail("marker", "is missing: at least one [[marker]] with size, variant and side must say what is sought");
  detector.families.clear();
  for (TomlTable& table : tables)
    detector.families.push_back(ReadMarkerFamily(table, base, detector.camera.has_value()));
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

void ReadPublish(TomlTable table, const std::string& camera_name, LcmPublisherOptions& publish) {
  publish.prefix = DefaultPrefix(camera_name);
  table.Read("url", publish.url);
  AtKey(table, "url", [&] { return ParseLcmUrl(publish.url, LcmDirection::kPublish); });
  if (!table.Read("prefix", publish.prefix, LengthRange{1, kMaxPrefixLength})) return;
  if (const std::string wrong = publish.Check(); !wrong.empty()) table.Fail("prefix", wrong);
}

DaemonConfig ReadConfig(TomlFile& file, const std::filesystem::path& base) {
  DaemonConfig config;
  TomlTable root = file.root();
  ReadCamera(root.Table("camera"), base, config);
  config.capture = ReadCaptureOptions(root.Table("capture"), base);
  TakeSizeOfCalibration(config);
  ReadDetect(root.Table("detect"), config.detector);
  ReadMarkers(root, base, config.detector);
  ReadFrameTables(root, base, config);
  ReadPipeline(root.Table("pipeline"), config);
  ReadPublish(root.Table("publish"), config.camera_name, config.publish);
  ReadMetrics(root.Table("metrics"), base, config.metrics);
  TomlTable log = root.Table("log");
  log.Read("level", config.log.level, kLevels);
  log.Read("target", config.log.target, kTargets);
  file.CheckAllKeysRead();
  config.sections = root.Texts();
  return config;
}

}  // namespace

std::string DefaultPrefix(const std::string& camera_name) { return "CHEQUER_" + camera_name; }

DaemonConfig LoadDaemonConfig(const std::filesystem::path& path) {
  TomlFile file = TomlFile::Load(path);
  return ReadConfig(file, path.parent_path());
}

DaemonConfig ParseDaemonConfig(std::string_view text, const std::string& name, const std::filesystem::path& base) {
  TomlFile file = TomlFile::Parse(text, name);
  return ReadConfig(file, base);
}

}  // namespace chequer
