#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/recording.h"

namespace chequer {

/// How fast a recording plays.
enum class ReplayPace : std::uint8_t {
  kRecorded,   ///< at the distances of its capture times
  kFixedRate,  ///< at ReplayOptions::fps
  kUnlimited,  ///< each frame as soon as it is asked for
};

/// Whether all frames are decoded before the first is played.
enum class Preload : std::uint8_t {
  kAuto,  ///< where decoding would be too slow for the pace, and the limit allows it
  kYes,
  kNo,
};

/// What the capture times of played frames are.
enum class ReplayTimes : std::uint8_t {
  kPlayed,    ///< when the frame was due (kUnlimited: handed out) now; latencies can be told from them
  kRecorded,  ///< when the frame was captured; of another day, and the monotonic one of another clock
};

struct ReplayOptions {
  std::filesystem::path path;                 ///< a recording, a folder of images, or one image
  std::vector<std::filesystem::path> images;  ///< instead of path: these, in this order
  PlainImageOptions plain;                    ///< of images without a recording.toml
  ReplayPace pace = ReplayPace::kRecorded;
  double fps = 30;    ///< of kFixedRate, 0.001..10000
  bool loop = false;  ///< begin again after the last frame
  Preload preload = Preload::kAuto;
  std::size_t preload_limit_bytes = std::size_t{128} << 20;  ///< keeps a daemon at 1080p below 200 MB
  ReplayTimes times = ReplayTimes::kPlayed;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

}  // namespace chequer
