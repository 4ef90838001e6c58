#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/fault.h"
#include "capture/frame_source.h"
#include "capture/waiting_clock.h"

namespace chequer {

/// A camera that misbehaves at given frames, around one that does not.
class FaultSource final : public FrameSource {
 public:
  /// @param clock the one that the camera behind waits on, if it takes one.
  FaultSource(std::unique_ptr<FrameSource> behind, std::vector<Fault> faults, std::shared_ptr<WaitingClock> clock);

  std::string Open() override;
  CaptureResult Next(std::chrono::milliseconds timeout) override;
  void Interrupt() override;
  std::string Describe() const override;
  std::vector<std::string> Remarks() const override { return behind_->Remarks(); }
  double rate_hz() const override { return behind_->rate_hz(); }
  double expected_rate_hz() const override { return behind_->expected_rate_hz(); }
  std::string Health() const override { return behind_->Health(); }

 private:
  /// The fault that happens at or before the next frame.
  const Fault* NextFault() const;
  /// Waits out a stall; false when the time is up before it is over.
  bool WaitOut(const Fault& stall, MonotonicTime deadline);
  CaptureResult Vanish(const Fault& fault);
  CaptureResult Spoil(const Fault& fault, CaptureResult result) const;

  std::unique_ptr<FrameSource> behind_;
  std::vector<Fault> faults_;  ///< by frame
  std::shared_ptr<WaitingClock> clock_;
  std::size_t next_fault_ = 0;
  std::uint64_t frames_ = 0;  ///< that came from behind
  std::uint64_t drop_until_ = 0;
  std::optional<MonotonicTime> stalled_until_;
  bool is_gone_ = false;
  int failed_opens_left_ = 0;
  MonotonicTime back_at_{};
};

}  // namespace chequer
