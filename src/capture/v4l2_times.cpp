#include "capture/v4l2_times.h"

namespace chequer {
namespace {

using std::chrono::microseconds;

/// How old the stamp of a frame can be that arrives now; more is a clock that we do not know.
constexpr std::chrono::seconds kOldest{1};

/// Whether a stamp can be a time of a clock that shows `now`.
bool Fits(microseconds stamp, microseconds now) { return stamp <= now && now - stamp < kOldest; }

}  // namespace

V4l2FrameTimes MapV4l2Times(microseconds stamp, V4l2Clock clock, ExposureInstant instant, const ArrivalTimes& arrival) {
  const microseconds monotonic_now = arrival.monotonic.time_since_epoch();
  const microseconds utc_now = arrival.utc.time_since_epoch();
  // A driver that names its clock may be late by more than a second, when nobody fetched the frame; never early.
  if (clock == V4l2Clock::kMonotonic ? stamp.count() > 0 && stamp <= monotonic_now : Fits(stamp, monotonic_now))
    return {MonotonicTime(stamp), arrival.utc - (monotonic_now - stamp), instant};
  if (clock == V4l2Clock::kUnknown && Fits(stamp, utc_now))
    return {arrival.monotonic - (utc_now - stamp), UtcTime(stamp), instant};
  return {arrival.monotonic, arrival.utc, ExposureInstant::kUnknown};
}

}  // namespace chequer
