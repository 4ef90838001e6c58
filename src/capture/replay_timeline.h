#pragma once

#include <chrono>
#include <cstdint>

#include "capture/recording.h"
#include "chequer/frame.h"

namespace chequer {

/// When the frames of a recording that plays over and over are due. Positions count played frames from 0; where the
/// recording begins again, times and sequence numbers go on.
class ReplayTimeline {
 public:
  /// At the recorded distances, or, with fps > 0, at that rate. The recording must live as long. @pre it has frames.
  ReplayTimeline(const Recording& recording, double fps);

  std::size_t IndexAt(std::uint64_t position) const { return static_cast<std::size_t>(position % count_); }
  /// Since position 0.
  std::chrono::microseconds DueAt(std::uint64_t position) const;
  /// As recorded; later rounds count on from the last frame's.
  std::uint64_t SequenceAt(std::uint64_t position) const;
  /// As recorded; later rounds follow after the length of the recording and one mean distance of frames.
  UtcTime RecordedUtcAt(std::uint64_t position) const;
  MonotonicTime RecordedMonotonicAt(std::uint64_t position) const;
  /// The mean distance of two frames.
  std::chrono::microseconds MeanPeriod() const;

 private:
  const Recording& recording_;
  double fps_;
  std::uint64_t count_;
  std::chrono::microseconds round_{};  ///< one round as recorded
};

}  // namespace chequer
