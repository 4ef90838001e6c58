#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/camera_options.h"
#include "capture/frame_source.h"
#include "capture/image_pool.h"
#include "capture/silence_watch.h"
#include "capture/v4l2_nodes.h"
#include "capture/v4l2_setup.h"
#include "capture/v4l2_stream.h"
#include "core/clock.h"
#include "core/unique_fd.h"

namespace chequer {

/// A camera of Video4Linux, through libv4l2 with its conversions off.
///
/// - Frames lie in the driver's own buffers, which go back to it when a frame dies. Only JPEGs are decoded, into planar
///   YUV; and where the driver gave so few buffers that it would have none left to fill, the frame is copied, as it is
///   with v4l2loopback, whose feeder writes into buffers that we still hold.
/// - A camera that is gone, or silent (SilenceWatch), is kDisconnected; Open() finds the same one again, also under
///   another node.
class V4l2Source final : public FrameSource {
 public:
  explicit V4l2Source(V4l2Options options, V4l2Roots roots = {}, Clock clock = Clock::System());
  ~V4l2Source() override;

  /// Throws where the camera cannot do what is asked, where several cameras are meant, and where it may not be opened,
  /// and that for some seconds: rights that come later come with the node.
  std::string Open() override;
  CaptureResult Next(std::chrono::milliseconds timeout) override;
  void Interrupt() override;
  std::string Describe() const override;
  std::vector<std::string> Remarks() const override { return remarks_; }
  double rate_hz() const override { return rate_hz_; }

 private:
  V4l2Device OpenDevice();
  void Close();
  CaptureResult Lost(const std::string& why);
  enum class Woken { kByFrame, kByError, kByInterrupt, kByTime };
  Woken Wait(std::chrono::microseconds time) const;
  CaptureResult Take(const V4l2Filled& filled);
  CaptureResult TakeRaw(const V4l2Filled& filled);
  CaptureResult TakeJpeg(const V4l2Filled& filled);
  std::optional<ImageView> View(std::span<const std::uint8_t> bytes) const;

  V4l2Options options_;
  V4l2Roots roots_;
  Clock clock_;
  UniqueFd wake_;
  std::optional<V4l2Node> node_;  ///< the camera, once it was open
  std::optional<MonotonicTime> forbidden_since_;
  std::shared_ptr<V4l2Stream> stream_;  ///< shared with the frames; set while open
  std::shared_ptr<ImagePool> pool_ = ImagePool::Make();
  V4l2Layout layout_;
  bool must_copy_ = false;
  double rate_hz_ = 0;
  SilenceWatch silence_;
  std::vector<std::string> remarks_;
  std::uint64_t sequence_ = 0;  ///< of the last frame, without the driver's turning over
};

}  // namespace chequer
