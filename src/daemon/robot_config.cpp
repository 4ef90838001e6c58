#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "daemon/config.h"
#include "world/side_check.h"

namespace chequer {
namespace {

template <typename Enum, std::size_t count>
using Words = std::array<std::pair<std::string_view, Enum>, count>;

constexpr Words<PublishedFrames, 3> kFrames{
    {{"world", PublishedFrames::kWorld}, {"camera", PublishedFrames::kCamera}, {"both", PublishedFrames::kBoth}}};
constexpr Words<Motion, 2> kMotions{{{"straight", Motion::kStraight}, {"turning", Motion::kTurning}}};
constexpr Words<TrackTime, 2> kTimes{{{"capture", TrackTime::kCapture}, {"publish", TrackTime::kPublish}}};

constexpr double kRadPerDegree = std::numbers::pi / 180;

/// Turns what `load` throws, which names its own file and line, into a message that begins with the place of the key.
template <typename Load>
auto LoadAt(const TomlTable& table, std::string_view key, Load&& load) {
  try {
    return std::forward<Load>(load)();
  } catch (const std::runtime_error& error) {
    table.Fail(key, error.what());
  }
}

void NeedCalibration(const TomlTable& table, std::string_view key, const DaemonConfig& config) {
  if (!config.detector.camera) table.Fail(key, "needs camera.calibration: without it there are no poses");
}

std::chrono::milliseconds Milliseconds(double in_seconds) {
  return std::chrono::milliseconds(std::llround(1000 * in_seconds));
}

void ReadWorld(TomlTable table, const std::filesystem::path& base, DaemonConfig& config) {
  FramePublisherOptions& frames = config.frames;
  std::string file;
  if (table.Read("file", file)) {
    NeedCalibration(table, "file", config);
    frames.world = LoadAt(table, "file", [&] { return LoadWorld(base / file); });
    const std::string wrong = SideContradiction(*frames.world, config.detector.families);
    if (!wrong.empty()) table.Fail("file", wrong);
  }
  if (table.Read("frames", frames.frames, kFrames) && !frames.world && frames.frames != PublishedFrames::kCamera)
    table.Fail("frames", "needs world.file: where the camera stands is not known");
  table.ReadLength("drift_limit", frames.drift.limit_m, NumberRange{0.0001, 10});
  double window_s = 0;
  if (table.Read("drift_window", window_s, NumberRange{0.1, 600})) frames.drift.window = Milliseconds(window_s);
  if (const std::string wrong = frames.drift.Check(); !wrong.empty()) table.Fail("drift_limit", wrong);
}

void ReadRobots(TomlTable table, const std::filesystem::path& base, DaemonConfig& config) {
  FramePublisherOptions& frames = config.frames;
  std::string file;
  if (table.Read("file", file)) {
    NeedCalibration(table, "file", config);
    frames.roster = LoadAt(table, "file", [&] { return LoadRobotRoster(base / file, config.detector.families); });
    SetPrints(*frames.roster, config.detector.families);
  }
  const auto need_roster = [&](std::string_view key, bool asked) {
    if (asked && !frames.roster) table.Fail(key, "needs robots.file: which robots there are");
  };
  table.Read("ignore_others", frames.ignore_others);
  need_roster("ignore_others", frames.ignore_others);
  table.Read("floor", frames.floor_mode);
  need_roster("floor", frames.floor_mode);
  if (frames.floor_mode && !frames.world) table.Fail("floor", "needs world.file: where the floor is");
  table.ReadLength("max_height_error", frames.max_height_error_m, NumberRange{0.001, 10});
  double tilt_deg = 0;
  if (table.Read("max_tilt", tilt_deg, NumberRange{1, 180})) frames.max_tilt_rad = tilt_deg * kRadPerDegree;
}

void ReadTracks(TomlTable table, DaemonConfig& config) {
  FramePublisherOptions& frames = config.frames;
  if (table.Read("enabled", frames.tracks) && frames.tracks) NeedCalibration(table, "enabled", config);
  table.Read("time", frames.track_time, kTimes);
  const CaptureOptions& capture = config.capture;
  const bool times_are_old = capture.source == SourceKind::kReplay && capture.replay.times == ReplayTimes::kRecorded;
  if (frames.track_time == TrackTime::kPublish && times_are_old)
    table.Fail("time", "cannot be \"publish\" with capture.times = \"recorded\": the frames are of another time");
  TrackerOptions& tracker = frames.tracker;
  table.Read("motion", tracker.model.motion, kMotions);
  table.Read("acceleration", tracker.model.acceleration_m_s2, NumberRange{0.001, 1000});
  double turning_deg = 0;
  if (table.Read("angular_acceleration", turning_deg, NumberRange{0.1, 100'000}))
    tracker.model.angular_acceleration_rad_s2 = turning_deg * kRadPerDegree;
  table.Read("gate", tracker.gate, NumberRange{2, 100});
  double coast_s = 0;
  if (table.Read("coast", coast_s, NumberRange{0.01, 60})) tracker.coast = Milliseconds(coast_s);
  table.Read("refused_to_restart", tracker.refused_to_restart, IntegerRange{2, 1000});
}

}  // namespace

void ReadFrameTables(TomlTable& root, const std::filesystem::path& base, DaemonConfig& config) {
  ReadWorld(root.Table("world"), base, config);
  ReadRobots(root.Table("robots"), base, config);
  ReadTracks(root.Table("tracks"), config);
}

}  // namespace chequer
