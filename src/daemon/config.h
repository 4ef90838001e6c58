#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/source_factory.h"
#include "chequer/detector.h"
#include "core/toml_reader.h"
#include "publish/lcm_publisher.h"

namespace chequer {

enum class LogLevel : std::uint8_t { kDebug, kInfo, kWarning, kError };
enum class LogTarget : std::uint8_t {
  kAuto,     ///< the journal where systemd connected standard error to it, else the console
  kConsole,  ///< standard error
  kJournal,
};

struct LogOptions {
  LogLevel level = LogLevel::kInfo;
  LogTarget target = LogTarget::kAuto;
};

enum class WhenBusyChoice : std::uint8_t {
  kAuto,  ///< kWait for a recording as fast as it goes, else kNewest
  kNewest,
  kWait,
};

/// Everything that varies of chequerd. config/chequerd.toml documents each key.
struct DaemonConfig {
  std::string camera_name = "camera";
  CaptureOptions capture;
  DetectorOptions detector;  ///< with the calibration, if one is given
  int workers = 0;           ///< 0: one a core
  WhenBusyChoice when_busy = WhenBusyChoice::kAuto;
  LcmPublisherOptions publish;
  LogOptions log;
};

/// Channel prefix unless another is configured: CHEQUER_<camera name>.
std::string DefaultPrefix(const std::string& camera_name);

/// Reads a configuration and the files it names (calibration, tables). Relative paths are relative to the
/// configuration's folder. Throws std::runtime_error naming file, line, key, value and what would be right.
DaemonConfig LoadDaemonConfig(const std::filesystem::path& path);

/// The same from a text. @param name stands for the file in messages. @param base what paths are relative to.
DaemonConfig ParseDaemonConfig(std::string_view text, const std::string& name, const std::filesystem::path& base);

/// Reads one [[marker]]. Throws as LoadDaemonConfig.
/// @param need_side whether poses are wanted, which need the side.
MarkerFamily ReadMarkerFamily(TomlTable& table, const std::filesystem::path& base, bool need_side);

}  // namespace chequer
