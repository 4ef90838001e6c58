#pragma once

#include <cstdint>
#include <string>

#include "publish/messages.h"

namespace chequer {

/// What the capture thread tells of itself.
struct CaptureReport {
  CameraState state = CameraState::kWaiting;
  std::string source;             ///< FrameSource::Describe
  std::string message;            ///< what is wrong now; empty where nothing is
  std::uint64_t lost_before = 0;  ///< gaps in the camera's count
  std::uint64_t corrupt = 0;      ///< frames that came and could not be used
  std::uint64_t wrong_size = 0;   ///< frames of another size than the calibration's

  /// Frames that never reached the queue.
  std::uint64_t unusable() const { return lost_before + corrupt + wrong_size; }
};

}  // namespace chequer
