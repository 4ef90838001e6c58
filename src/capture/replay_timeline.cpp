#include "capture/replay_timeline.h"

#include <cmath>

namespace chequer {
namespace {

using std::chrono::microseconds;

/// base + rounds · length. A recording may claim any times; wrapping around is harmless, overflow of signed numbers
/// not.
microseconds After(microseconds base, std::uint64_t rounds, microseconds length) {
  const auto sum = static_cast<std::uint64_t>(base.count()) + rounds * static_cast<std::uint64_t>(length.count());
  return microseconds(static_cast<std::int64_t>(sum));
}

}  // namespace

ReplayTimeline::ReplayTimeline(const Recording& recording, double fps)
    : recording_(recording), fps_(fps), count_(recording.frames.size()) {
  const microseconds span = recording.frames.back().captured_monotonic - recording.frames.front().captured_monotonic;
  const microseconds period =
      count_ > 1 ? span / static_cast<std::int64_t>(count_ - 1) : microseconds(std::llround(1e6 / recording.info.fps));
  round_ = span + period;
}

microseconds ReplayTimeline::DueAt(std::uint64_t position) const {
  if (fps_ > 0) return microseconds(std::llround(1e6 * static_cast<double>(position) / fps_));
  const auto since_first =
      recording_.frames[IndexAt(position)].captured_monotonic - recording_.frames.front().captured_monotonic;
  return After(since_first, position / count_, round_);
}

std::uint64_t ReplayTimeline::SequenceAt(std::uint64_t position) const {
  const std::uint64_t numbers = recording_.frames.back().sequence - recording_.frames.front().sequence + 1;
  return recording_.frames[IndexAt(position)].sequence + position / count_ * numbers;
}

UtcTime ReplayTimeline::RecordedUtcAt(std::uint64_t position) const {
  const UtcTime recorded = recording_.frames[IndexAt(position)].captured_utc;
  return UtcTime(After(recorded.time_since_epoch(), position / count_, round_));
}

MonotonicTime ReplayTimeline::RecordedMonotonicAt(std::uint64_t position) const {
  const MonotonicTime recorded = recording_.frames[IndexAt(position)].captured_monotonic;
  return MonotonicTime(After(recorded.time_since_epoch(), position / count_, round_));
}

microseconds ReplayTimeline::MeanPeriod() const {
  if (fps_ > 0) return microseconds(std::llround(1e6 / fps_));
  return round_ / static_cast<std::int64_t>(count_);
}

}  // namespace chequer
