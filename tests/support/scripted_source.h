#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "capture/frame_source.h"

namespace chequer::test {

/// One thing that a scripted camera does.
struct Step {
  enum class Kind {
    kOpens,        ///< Open() succeeds
    kOpenFails,    ///< Open() answers `text`
    kOpenThrows,   ///< Open() throws std::runtime_error(`text`)
    kFrame,        ///< Next() gives a frame with `sequence`
    kResult,       ///< Next() gives `status` with `text`
    kInterrupted,  ///< Next() waits for Interrupt() and then gives kTimeout
  };
  Kind kind = Kind::kFrame;
  std::uint64_t sequence = 0;
  CaptureStatus status = CaptureStatus::kTimeout;
  std::string text{};
  int width = 4;  ///< of a frame; its height is 2
};

Step Opens();
Step OpenFails(std::string message);
Step OpenThrows(std::string message);
Step FrameNumber(std::uint64_t sequence, int width = 4);
Step Gives(CaptureStatus status, std::string message = {});
/// The source has come to its end.
inline const Step kEnd = Gives(CaptureStatus::kEnd);
Step WaitsForInterrupt();

/// Frames `first`, …, `last`.
std::vector<Step> Frames(std::uint64_t first, std::uint64_t last);
/// One script after the other.
std::vector<Step> operator+(std::vector<Step> first, std::vector<Step> second);

/// A camera that does what its script says, in order and at once. Open() without a step for it succeeds; after the last
/// step it waits to be interrupted. A frame is Mono8, its captured_monotonic is `sequence` milliseconds, its first
/// eight pixels are the sequence number (little-endian).
class ScriptedSource final : public FrameSource {
 public:
  explicit ScriptedSource(std::vector<Step> script);

  std::string Open() override;
  CaptureResult Next(std::chrono::milliseconds timeout) override;
  void Interrupt() override;
  std::string Describe() const override { return "scripted camera"; }
  std::vector<std::string> Remarks() const override { return remarks; }
  std::string Health() const override { return health; }
  double rate_hz() const override { return rate; }

  std::vector<std::string> remarks;
  std::string health;
  double rate = 0;  ///< frames a second

  int opened() const { return opened_; }
  /// Counts the frames whose buffers have not come back.
  std::shared_ptr<std::atomic<int>> leases() const { return leases_; }

 private:
  CaptureResult MakeFrame(const Step& step);
  CaptureResult WaitForInterrupt();

  std::deque<Step> script_;
  int opened_ = 0;
  std::shared_ptr<std::atomic<int>> leases_ = std::make_shared<std::atomic<int>>(0);
  std::mutex mutex_;
  std::condition_variable interrupt_;
  bool interrupted_ = false;
};

/// The sequence number in the pixels of a scripted frame.
std::uint64_t SequenceIn(const ImageView& image);

}  // namespace chequer::test
