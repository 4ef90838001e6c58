#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "capture/frame_source.h"
#include "core/back_off.h"
#include "core/clock.h"
#include "core/repeated_cause.h"
#include "daemon/capture_report.h"
#include "daemon/progress.h"
#include "daemon/sequence_counter.h"
#include "daemon/shared.h"

namespace chequer {

/// Pixels.
struct FrameSize {
  int width = 0;
  int height = 0;
  bool operator==(const FrameSize&) const = default;
};

struct CaptureLoopOptions {
  /// Frames of another size are refused: the calibration does not hold for them. Empty: any size.
  std::optional<FrameSize> size;
  /// Between attempts at opening a source that is not there. It is plugged in by a person or comes with the boot: a
  /// quarter of a second is not felt. Asking the network for cameras takes a second by itself, so that even with the
  /// longest wait poses come again some two seconds after a camera does.
  std::chrono::milliseconds first_reopen{250};
  std::chrono::milliseconds longest_reopen{1000};
  /// Complain when no frame came for that long.
  std::chrono::milliseconds stall{2000};
};

/// A frame on its way to a worker.
struct CapturedFrame {
  Frame frame;                       ///< its sequence is the published one
  MonotonicTime arrived{};           ///< when the source handed it out
  std::uint64_t dropped_before = 0;  ///< frames that did not get as far as this one, since the start
  double rate_hz = 0;                ///< FrameSource::expected_rate_hz
};

/// Opens a source, passes its frames on, opens it again whenever it is gone. Tells what happens in `report`, and in the
/// log once a cause. Runs on one thread.
class CaptureLoop {
 public:
  /// @param pass takes each frame; false: nobody wants more.
  /// @param sequence numbers the frames; it outlives the loop, as the numbers go on in the next one.
  CaptureLoop(CaptureLoopOptions options, FrameSource& source, std::function<bool(CapturedFrame)> pass,
              Shared<CaptureReport>& report, SequenceCounter& sequence, CaptureActivity& activity, Clock clock);

  /// The source is open already: Run begins with its frames. Call it before Run.
  void TakeOpenSource() { is_open_ = true; }

  /// Until the recording is over, or stopped (the stop must be followed by source.Interrupt()).
  /// Throws what FrameSource::Open throws: a source that can never work.
  void Run(std::stop_token stop);

  /// Whether the source was left open when Run returned.
  bool source_is_open() const { return is_open_; }

 private:
  enum class Next { kGoOn, kReopen, kFinish };

  bool Open(const std::stop_token& stop);
  void TellRemarks();
  void TellHealth();
  Next Take(CaptureResult result);
  Next TakeFrame(Frame frame);
  void Unusable(const std::string& why);
  void CountMissed();
  void NoFrame();
  void Recover();
  void Complain(std::string_view cause, std::string_view detail);
  void WaitToReopen(const std::stop_token& stop);

  CaptureLoopOptions options_;
  FrameSource& source_;
  std::function<bool(CapturedFrame)> pass_;
  Shared<CaptureReport>& report_;
  SequenceCounter& sequence_;
  CaptureActivity& activity_;
  Clock clock_;
  bool is_open_ = false;
  BackOff back_off_;
  RepeatedCause trouble_;       ///< the source is not there, or silent
  RepeatedCause bad_frames_;    ///< it is there, and frames are unusable
  MonotonicTime last_frame_{};  ///< or when it was opened
  bool had_frame_ = false;
  bool last_was_unusable_ = false;
  std::optional<MonotonicTime> away_since_;  ///< the last frame's arrival, from when the camera was lost on
  MonotonicTime health_told_{};
  std::vector<std::string> remarks_;  ///< that were logged
  std::mutex mutex_;
  std::condition_variable_any wake_;
};

}  // namespace chequer
