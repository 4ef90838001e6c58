#pragma once

#include <cstdint>
#include <optional>

namespace chequer {

/// Turns a camera's frame numbers, which begin anew when it is opened again, into numbers that always rise, and tells
/// how many frames were lost before each. One thread.
class SequenceCounter {
 public:
  struct Counted {
    std::uint64_t sequence = 0;
    std::uint64_t lost = 0;  ///< frames missing since the last one, unusable ones not counted again
  };

  /// A frame came. The first keeps the camera's number. A number that is not above the last one means that the camera
  /// began to count anew; how many were lost then is not known and taken as none.
  Counted Frame(std::uint64_t camera_sequence);

  /// Another camera took the place of the one there was: its first number says nothing of frames that were lost.
  void CameraReplaced() { replaced_ = true; }

  /// The camera was away for so long that it would have given so many frames. Its next number begins anew.
  void Missed(std::uint64_t frames) { missed_ = frames; }

  /// A frame came that cannot be used. Its number is unknown, so the gap that it will leave is not counted as lost.
  void UnusableFrame() { ++unusable_; }

 private:
  std::optional<std::uint64_t> last_camera_;
  std::uint64_t last_ = 0;
  std::uint64_t unusable_ = 0;
  std::uint64_t missed_ = 0;
  bool replaced_ = false;
};

}  // namespace chequer
