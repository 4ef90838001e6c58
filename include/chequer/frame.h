#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "chequer/image.h"

namespace chequer {

/// UTC, microseconds since 1970.
using UtcTime = std::chrono::sys_time<std::chrono::microseconds>;
/// CLOCK_MONOTONIC of this host, microseconds.
using MonotonicTime = std::chrono::time_point<std::chrono::steady_clock, std::chrono::microseconds>;

/// The instant of a frame that its capture time names.
enum class ExposureInstant : std::uint8_t { kUnknown, kStart, kMiddle, kEnd };

/// Keeps the pixels of a frame alive; destroying it gives the buffer back to its source.
/// May be destroyed on any thread, also after its source.
class FrameLease {
 public:
  virtual ~FrameLease() = default;
};

/// One captured frame. Move-only: the buffer has one owner.
struct Frame {
  ImageView image;                    ///< valid while `lease` lives
  std::unique_ptr<FrameLease> lease;  ///< may be null where the pixels need no keeping
  UtcTime captured_utc{};             ///< of the instant that `instant` names
  MonotonicTime captured_monotonic{};
  ExposureInstant instant = ExposureInstant::kUnknown;
  /// Counts the camera's frames; a gap is frames that were lost before they reached us.
  std::uint64_t sequence = 0;
  std::string name;  ///< where it came from (a file's name); may be empty
};

}  // namespace chequer
