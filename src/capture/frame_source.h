#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "chequer/frame.h"

namespace chequer {

/// What became of waiting for a frame.
enum class CaptureStatus {
  kFrame,         ///< `frame` is valid
  kTimeout,       ///< nothing came in time; the source still stands
  kCorrupt,       ///< a frame came and could not be used; it is gone, the source still stands
  kDisconnected,  ///< the source is gone; Open() may bring it back
  kEnd,           ///< the recording is over; nothing more will come
};

struct CaptureResult {
  CaptureStatus status = CaptureStatus::kTimeout;
  Frame frame;          ///< valid only with kFrame
  std::string message;  ///< says what is wrong with kCorrupt and kDisconnected
};

/// A camera, or what stands for one. One thread calls it; leases it gave out may die on any thread and outlive it.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Opens, or opens again after kDisconnected. Empty on success, else what was asked, what is there and what to do.
  /// Throws std::runtime_error where waiting cannot help (a configuration that can never work).
  virtual std::string Open() = 0;

  /// Waits for the next frame, at most `timeout`; returns early when Interrupt() was called.
  virtual CaptureResult Next(std::chrono::milliseconds timeout) = 0;

  /// Makes the Next() that waits, or the next one, return kTimeout at once. The only call allowed from another thread.
  virtual void Interrupt() = 0;

  /// One line for logs and status, such as "recording /data/swarm, 640x480 BGR8, 60 fps".
  virtual std::string Describe() const = 0;

  /// What the last Open() could not do quite as asked, and went on without; a sentence each.
  virtual std::vector<std::string> Remarks() const { return {}; }

  /// Frames a second that it means to deliver; 0: unknown, or as they are asked for.
  virtual double rate_hz() const { return 0; }

  /// Frames a second to be ready for; 0: unknown, or as they are asked for. Of a camera its rate; a recording has one too,
  /// but loses none while it is away.
  virtual double expected_rate_hz() const { return rate_hz(); }

  /// How it fares beside what its frames tell, such as "3 packets resent"; empty where there is nothing to tell.
  virtual std::string Health() const { return {}; }
};

}  // namespace chequer
