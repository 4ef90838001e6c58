#pragma once

#include <memory>

#include "chequer/frame.h"

namespace chequer {

/// Time as a source sees it, and waiting in it. Tests hand in one that they drive, so that nothing sleeps.
class WaitingClock {
 public:
  virtual ~WaitingClock() = default;

  virtual MonotonicTime Now() const = 0;
  virtual UtcTime NowUtc() const = 0;

  /// Waits until that time, not at all if it has passed. False, and at once, when interrupted; that uses up the
  /// interruption.
  virtual bool WaitUntil(MonotonicTime time) = 0;

  /// Makes the WaitUntil that waits, or the next one, return false. Any thread.
  virtual void Interrupt() = 0;

  /// Whether an interruption waits to be used up.
  virtual bool IsInterrupted() const = 0;
};

/// The host's clocks.
std::unique_ptr<WaitingClock> MakeSystemClock();

}  // namespace chequer
