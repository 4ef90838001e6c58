#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "chequer/detector.h"
#include "chequer/frame.h"
#include "core/clock.h"
#include "core/unique_fd.h"
#include "publish/view_messages.h"

namespace chequer {

struct FrameViewerOptions {
  std::string url;     ///< of LCM
  std::string prefix;  ///< of the channels
  CameraMessage camera;
  DetectorOptions detector;
};

/// A frame that a worker is done with, for those who look.
struct ViewedFrame {
  Frame frame;
  std::optional<MarkerPose> chosen;  ///< the marker of which the detail is asked for, if it was found
};

/// Answers those who look (ask_t): previews, the detail of a marker, the camera. All that costs time happens on a
/// thread of its own, which gives way to all others, over a connection to LCM of its own: no pose
/// waits. A worker hands over a frame, with its buffer, when one is due. Opens no connection and asks for no frame
/// while nobody looks.
class FrameViewer {
 public:
  /// Throws std::system_error where the system has no descriptor left.
  FrameViewer(FrameViewerOptions options, Clock clock);
  ~FrameViewer();

  /// Whether the next frame is wanted. Any thread, at next to no cost.
  bool WantsFrame(MonotonicTime now) const {
    return now.time_since_epoch().count() >= wanted_from_us_.load(std::memory_order_relaxed);
  }
  /// The marker of these whose detail is wanted, if there is one. Any thread.
  std::optional<MarkerPose> Choose(const std::vector<MarkerPose>& markers) const;
  /// Takes a frame; it goes where another waits. Any thread, does not wait.
  void Offer(ViewedFrame frame);

  /// Answers until it is closed: what the thread does.
  void Run();
  /// Ends Run, and gives back a frame that waits. Any thread.
  void Close();

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  struct Impl;

  std::atomic<std::int64_t> wanted_from_us_{kNever};
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer
