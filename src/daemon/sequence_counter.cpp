#include "daemon/sequence_counter.h"

#include <algorithm>
#include <utility>

namespace chequer {

SequenceCounter::Counted SequenceCounter::Frame(std::uint64_t camera_sequence) {
  const std::uint64_t unusable = std::exchange(unusable_, 0);
  const auto last_camera = std::exchange(last_camera_, camera_sequence);
  const bool replaced = std::exchange(replaced_, false);
  const std::uint64_t missed = std::exchange(missed_, 0);
  if (!last_camera) {
    last_ = camera_sequence;
    return {last_, 0};
  }
  const bool anew = replaced || missed > 0 || camera_sequence <= *last_camera;
  const std::uint64_t gap = anew ? unusable + missed : camera_sequence - *last_camera - 1;
  last_ += gap + 1;
  return {last_, gap - std::min(gap, unusable)};
}

}  // namespace chequer
