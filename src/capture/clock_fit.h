#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "chequer/frame.h"

namespace chequer {

/// Maps times of a camera's clock to this host's monotonic clock, from pairs of a frame's stamp and its arrival.
///
/// An arrival is late by the way from the camera, never early, so what the clocks differ is read from the frames that
/// were the fastest of each second; a line through them follows the drift of the camera's clock. What even the fastest
/// needed, some tenths of a millisecond, stays in. Begins anew where the camera's clock jumps. One thread.
class ClockFit {
 public:
  /// A frame stamped `device` by the camera arrived at `arrived`.
  void Add(std::chrono::nanoseconds device, MonotonicTime arrived);

  /// The host's time of a stamp. @pre a frame was added.
  MonotonicTime Map(std::chrono::nanoseconds device) const;

  /// How far the mapping may be off beside the way of the fastest frame: the root mean square distance of the fastest
  /// frames of each second from the line. Nothing in the first seconds, when it cannot be told.
  std::optional<std::chrono::microseconds> error() const { return error_; }

 private:
  /// The fastest frame of a second.
  struct Fastest {
    std::int64_t second = 0;   ///< of the camera's clock
    double device_us = 0;      ///< since origin_
    double difference_us = 0;  ///< arrival − stamp, since base_
  };

  bool HasJumped(double device_us, double difference_us) const;
  void Fit();

  std::chrono::nanoseconds origin_{};
  std::int64_t base_us_ = 0;
  std::deque<Fastest> seconds_;
  double last_device_us_ = 0;
  double offset_us_ = 0;
  double drift_ = 0;
  std::optional<std::chrono::microseconds> error_;
};

/// UTC of a stamp of a clock that follows PTP, whose time is TAI, or UTC with some masters; nothing where the stamp is
/// neither within `tolerance` of what the fit says, so that the clock does not follow PTP yet.
/// @param tai_minus_utc 37 s since 2017.
std::optional<UtcTime> UtcOfPtp(std::chrono::nanoseconds device, UtcTime fitted, std::chrono::seconds tai_minus_utc,
                                std::chrono::microseconds tolerance);

}  // namespace chequer
