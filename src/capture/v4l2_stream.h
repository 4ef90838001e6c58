#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/v4l2_device.h"
#include "capture/v4l2_times.h"
#include "chequer/frame.h"

namespace chequer {

/// A buffer that the driver has filled.
struct V4l2Filled {
  std::uint32_t index = 0;
  std::span<const std::uint8_t> bytes;  ///< what was filled, in the driver's own memory
  std::uint32_t sequence = 0;
  std::chrono::microseconds stamp{};
  V4l2Clock clock = V4l2Clock::kUnknown;
  ExposureInstant instant = ExposureInstant::kUnknown;
  bool is_damaged = false;  ///< the driver says so
};

/// The buffers of a device that streams. Shared by the source and the frames that look into them, which may outlive it:
/// the memory stays mapped until the last of them is gone. Any thread.
class V4l2Stream : public std::enable_shared_from_this<V4l2Stream> {
 public:
  /// Starts streaming. Throws CameraNotReady, or std::runtime_error where the driver cannot stream.
  static std::shared_ptr<V4l2Stream> Start(V4l2Device device, int buffers);
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;

  const V4l2Device& device() const { return device_; }

  /// A filled buffer, or none yet with error EAGAIN, or the error that says what is wrong.
  struct Dequeued {
    std::optional<V4l2Filled> filled;
    int error = 0;
  };
  Dequeued Dequeue();

  /// Gives a buffer back to the driver; nothing once it was stopped.
  void Requeue(std::uint32_t index);

  /// Keeps a buffer for a frame and gives it back when the frame dies.
  std::unique_ptr<FrameLease> Lend(std::uint32_t index);

  /// Buffers that the driver can fill now.
  int queued() const;
  int count() const { return static_cast<int>(mapped_.size()); }

  /// Ends streaming and closes the device. Memory that frames still look into stays.
  void Stop();

 private:
  struct Mapping {
    void* address = nullptr;
    std::size_t length = 0;
  };

  explicit V4l2Stream(V4l2Device device) : device_(std::move(device)) {}
  void Map(int buffers);
  int Queue(std::uint32_t index);

  mutable std::mutex mutex_;
  V4l2Device device_;
  std::vector<Mapping> mapped_;
  int queued_ = 0;
  bool streaming_ = false;
};

}  // namespace chequer
