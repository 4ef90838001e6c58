#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "capture/source_factory.h"
#include "chequer/detector.h"
#include "core/toml_reader.h"
#include "daemon/frame_budget.h"
#include "daemon/frame_publisher.h"
#include "daemon/log_options.h"
#include "daemon/metrics_options.h"
#include "daemon/scheduling.h"
#include "publish/lcm_publisher.h"

namespace chequer {

enum class WhenBusyChoice : std::uint8_t {
  kAuto,  ///< kWait for a recording as fast as it goes, else kNewest
  kNewest,
  kWait,
};

enum class ThreadsChoice : std::uint8_t {
  kAuto,    ///< as many as there are processors, four at most; one where the source waits for the workers
  kNumber,  ///< DetectorOptions::threads
};

/// Everything that varies of chequerd. config/chequerd.toml documents each key.
struct DaemonConfig {
  std::string camera_name = "camera";
  CaptureOptions capture;
  DetectorOptions detector;                      ///< with the calibration, if one is given
  ThreadsChoice threads = ThreadsChoice::kAuto;  ///< for one frame
  int workers = 0;                               ///< 0: one a core
  WhenBusyChoice when_busy = WhenBusyChoice::kAuto;
  BudgetOptions budget;  ///< of a frame
  bool memory = true;    ///< each frame is begun with what the last ones taught
  SchedulingOptions scheduling;
  /// The world, the robots and the tracks, with the files they name.
  FramePublisherOptions frames;
  LcmPublisherOptions publish;
  /// Whether those who look (`chequer view`) are answered; needs multicast.
  bool allow_view = true;
  MetricsOptions metrics;
  LogOptions log;
  /// What is allowed and looks like a mistake, each with its place, for whoever starts the daemon.
  std::vector<std::string> remarks;
  /// What each table of the file said, and the files it names, in a form in which equal texts mean the same: tells what
  /// a changed file changes.
  std::map<std::string, std::string> sections;
};

/// Reads a configuration and the files it names (calibration, tables). Relative paths are relative to the
/// configuration's folder; a camera without a name has the file's (CameraNameOf). Throws std::runtime_error naming
/// file, line, key, value and what would be right.
DaemonConfig LoadDaemonConfig(const std::filesystem::path& path);

/// The same from a text; a camera without a name is "camera". @param name stands for the file in messages. @param base
/// what paths are relative to.
DaemonConfig ParseDaemonConfig(std::string_view text, const std::string& name, const std::filesystem::path& base);

/// Reads [world], [robots] and [tracks] into config.frames. Throws as LoadDaemonConfig. @pre the camera, what is
/// captured and the families of `config` are read.
void ReadFrameTables(TomlTable& root, const std::filesystem::path& base, DaemonConfig& config);

}  // namespace chequer
