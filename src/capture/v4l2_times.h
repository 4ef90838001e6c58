#pragma once

#include <cstdint>

#include "chequer/frame.h"

namespace chequer {

/// Which clock a V4L2 driver stamps buffers with.
enum class V4l2Clock : std::uint8_t {
  kMonotonic,  ///< CLOCK_MONOTONIC of this host
  kUnknown,    ///< the driver does not say, or whoever feeds the device stamped them
};

/// The host's clocks, both read when a buffer came.
struct ArrivalTimes {
  MonotonicTime monotonic{};
  UtcTime utc{};
};

struct V4l2FrameTimes {
  MonotonicTime monotonic{};
  UtcTime utc{};
  ExposureInstant instant = ExposureInstant::kUnknown;
};

/// When a frame was captured. A stamp of the monotonic clock is moved to UTC by what the two clocks differ now. A stamp
/// of an unknown clock is taken as monotonic or as UTC where it lies within a second before the arrival on that clock;
/// else, and where a stamp lies after the arrival, the time of arrival stands for it, which is of no known instant.
/// @param instant what the driver says its stamp means: kStart or kEnd.
V4l2FrameTimes MapV4l2Times(std::chrono::microseconds stamp, V4l2Clock clock, ExposureInstant instant,
                            const ArrivalTimes& arrival);

}  // namespace chequer
