#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/camera_options.h"
#include "capture/frame_source.h"
#include "capture/replay_options.h"
#include "capture/waiting_clock.h"
#include "core/toml_reader.h"

namespace chequer {

/// Where frames come from.
enum class SourceKind : std::uint8_t { kReplay, kV4l2, kAravis };

struct CaptureOptions {
  SourceKind source = SourceKind::kReplay;
  ReplayOptions replay;             ///< of kReplay
  V4l2Options v4l2;                 ///< of kV4l2
  AravisOptions aravis;             ///< of kAravis
  std::vector<std::string> faults;  ///< of any source: what it does wrong, for tests (capture/fault.h)
};

/// Reads the table [capture] of a configuration:
///
///   source = "replay"            # or "v4l2", "aravis", whose keys capture/camera_config.h reads
///   path = "swarm"               # a recording, a folder of images or one image; or
///   images = ["a.png", …]        # these
///   fps = 30                     # of images without a recording.toml, 0.001..10000
///   one_channel = "Mono8"        # what grey images hold: Mono8, BayerRG8, BayerGB8, BayerGR8, BayerBG8
///   gamma = 2.2                  # of images without a recording.toml; left out: sRGB; 1: linear
///   pace = "recorded"            # or "fixed" (at replay_fps), "unlimited"
///   replay_fps = 30              # 0.001..10000
///   loop = false
///   preload = "auto"             # or "yes", "no"
///   preload_limit_mb = 128       # 1..65536
///   times = "played"             # capture times of played frames: of playing, or "recorded"
///   faults = []                  # such as ["stall 120 0.5s", "drop 200 3"]
///
/// Throws std::runtime_error naming file, line, key, value and what would be right.
/// @param base the folder that paths not beginning with / are relative to.
CaptureOptions ReadCaptureOptions(TomlTable table, const std::filesystem::path& base);

/// The options of the camera that is the source; null where it is a recording.
const CameraOptions* CameraOf(const CaptureOptions& options);
CameraOptions* CameraOf(CaptureOptions& options);

/// The source that the options describe, not yet open. Throws std::runtime_error, saying what would be right, where
/// they are not valid.
/// @param clock shared because each layer of a source and the test that drives it wait on the same one.
std::unique_ptr<FrameSource> MakeSource(const CaptureOptions& options, std::shared_ptr<WaitingClock> clock);
/// The same on the host's clocks.
std::unique_ptr<FrameSource> MakeSource(const CaptureOptions& options);

/// Throws std::runtime_error where a recording that is to be replayed cannot be opened. Cameras are not asked: one that
/// is not there is waited for.
void CheckRecording(const CaptureOptions& options);

}  // namespace chequer
