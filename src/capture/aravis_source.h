#pragma once

#include <atomic>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "capture/aravis_devices.h"
#include "capture/camera_options.h"
#include "capture/clock_fit.h"
#include "capture/frame_ids.h"
#include "capture/frame_source.h"
#include "capture/silence_watch.h"
#include "core/clock.h"

struct _ArvBuffer;

namespace chequer {

class AravisSession;

/// A GenICam camera (GigE Vision, USB3 Vision), through Aravis.
///
/// - Frames lie in Aravis's buffers, which go back to it when a frame dies. Frames of which packets are missing are
///   kCorrupt and never handed out.
/// - Capture times are the camera's own, mapped to this host by ClockFit: the instant at which the exposure starts, as
///   GenICam's naming conventions have it.
/// - A camera that is gone, or silent (SilenceWatch), is kDisconnected; Open() finds the same one again by its id and
///   serial number, also at another address. Letting go of one that is gone takes seconds, on a thread of its own.
class AravisSource final : public FrameSource {
 public:
  explicit AravisSource(AravisOptions options, Clock clock = Clock::System());
  ~AravisSource() override;

  /// Throws where the camera cannot do what is asked, and where several cameras are meant.
  std::string Open() override;
  CaptureResult Next(std::chrono::milliseconds timeout) override;
  void Interrupt() override;
  std::string Describe() const override;
  std::vector<std::string> Remarks() const override { return remarks_; }
  double rate_hz() const override { return rate_hz_; }
  std::string Health() const override;

 private:
  void OpenCamera();
  CaptureResult Lost(const std::string& why);
  /// Lets go of the camera, on a thread of its own: whether it answers shows only then.
  void LetGo(bool is_gone);
  /// Whether that thread has ended.
  bool HasLetGo();
  std::string TriggerIfDue(MonotonicTime now);
  CaptureResult Take(_ArvBuffer* buffer);
  void SetTimes(_ArvBuffer* buffer, Frame& frame);

  AravisOptions options_;
  Clock clock_;
  std::optional<AravisDevice> device_;      ///< the camera, once it was open
  std::mutex session_mutex_;                ///< Interrupt() comes from another thread
  std::shared_ptr<AravisSession> session_;  ///< shared with the frames and letting_go_; set while open
  std::atomic<bool> interrupted_ = false;   ///< while no session was there to be interrupted
  std::jthread letting_go_;
  std::future<void> has_let_go_;  ///< of that thread, which may outlive the source
  bool ptp_ = false;
  double rate_hz_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::string format_;
  MonotonicTime next_trigger_{};
  SilenceWatch silence_;
  FrameIds ids_;
  ClockFit fit_;
  std::vector<std::string> remarks_;
};

}  // namespace chequer
