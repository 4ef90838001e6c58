#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame_source.h"
#include "capture/recording.h"
#include "capture/replay_options.h"
#include "capture/replay_timeline.h"
#include "capture/waiting_clock.h"

namespace chequer {

/// Plays a recording as a camera would.
///
/// - Where it plays at a pace, it is a camera with kBuffers buffers: a caller that comes late gets the waiting frames
/// at
///   once, with the capture times at which they were due; frames beyond those are lost, the oldest first, which shows
///   as a gap in the sequence and is counted. The next frame is decoded before its time has come, not after.
/// - A frame that cannot be loaded is kCorrupt, with its file's name, and playing goes on.
/// - Playing begins with the first Next() after Open(). Open() again goes on where it was.
class ReplaySource final : public FrameSource {
 public:
  static constexpr std::uint64_t kBuffers = 4;  // what V4L2 drivers commonly give

  /// Throws std::runtime_error with ReplayOptions::Check's message if the options are not valid.
  /// @param clock shared because each layer of a source and the test that drives it wait on the same one.
  ReplaySource(ReplayOptions options, std::shared_ptr<WaitingClock> clock);

  /// Throws where the recording cannot be read: no waiting repairs it. An interruption while frames are preloaded ends
  /// it with a message.
  std::string Open() override;
  CaptureResult Next(std::chrono::milliseconds timeout) override;
  void Interrupt() override { clock_->Interrupt(); }
  std::string Describe() const override;
  double expected_rate_hz() const override;

  /// Frames that were lost because the caller came late.
  std::uint64_t frames_lost() const { return frames_lost_; }
  bool is_preloaded() const { return preloaded_ != nullptr; }

 private:
  /// A frame as decoded, or why it could not be.
  struct Decoded {
    Image image;
    std::string error;
  };
  using Decodeds = std::vector<Decoded>;

  bool IsPaced() const { return options_.pace != ReplayPace::kUnlimited; }
  bool IsOver() const { return !options_.loop && position_ >= recording_.frames.size(); }
  std::size_t DecodedBytes() const;
  Decoded Decode(std::size_t index) const;
  bool WantsPreload() const;
  /// False when interrupted.
  bool PreloadAll();
  MonotonicTime DueAt(std::uint64_t position) const;
  void LoseWhatNoBufferHolds();
  CaptureResult Deliver(MonotonicTime due);
  Frame MakeFrame(MonotonicTime due);

  ReplayOptions options_;
  std::shared_ptr<WaitingClock> clock_;
  Recording recording_;
  std::optional<ReplayTimeline> timeline_;  ///< set while open
  /// Shared by the frames that look into it, which may outlive the source.
  std::shared_ptr<const Decodeds> preloaded_;
  std::optional<Decoded> waiting_;  ///< the frame at position_, decoded ahead of its time
  std::uint64_t position_ = 0;
  std::optional<MonotonicTime> start_;  ///< when position 0 was, or would have been, due
  std::uint64_t frames_lost_ = 0;
};

}  // namespace chequer
