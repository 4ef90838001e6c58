#include "capture/v4l2_stream.h"

#include <libv4l2.h>
#include <linux/videodev2.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "capture/camera_trouble.h"

namespace chequer {
namespace {

struct StreamLease final : FrameLease {
  StreamLease(std::shared_ptr<V4l2Stream> of, std::uint32_t buffer) : stream(std::move(of)), index(buffer) {}
  ~StreamLease() override { stream->Requeue(index); }
  std::shared_ptr<V4l2Stream> stream;  ///< shared: the frame may outlive the source
  std::uint32_t index;
};

v4l2_buffer MakeBuffer(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.index = index;
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  return buffer;
}

[[noreturn]] void Fail(const char* what, int error) {
  const std::string message = std::string(what) + ": " + std::strerror(error);
  // Another program, or frames of ours that are still under way, hold the buffers; or it has just been unplugged. A
  // lack of memory or of bandwidth (ENOSPC, on USB) can pass too.
  if (error == EBUSY || error == ENODEV || error == ENOMEM || error == ENOSPC || error == EIO)
    throw CameraNotReady(error == EBUSY ? message + "; another program uses the camera (fuser -v names it)" : message);
  throw std::runtime_error(message);
}

}  // namespace

std::shared_ptr<V4l2Stream> V4l2Stream::Start(V4l2Device device, int buffers) {
  std::shared_ptr<V4l2Stream> stream(new V4l2Stream(std::move(device)));
  stream->Map(buffers);
  const std::lock_guard lock(stream->mutex_);
  for (std::uint32_t i = 0; i < stream->mapped_.size(); ++i)
    if (const int error = stream->Queue(i); error != 0) Fail("handing buffers to the driver", error);
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = stream->device_.Control(VIDIOC_STREAMON, &type); error != 0) Fail("starting to stream", error);
  stream->streaming_ = true;
  return stream;
}

void V4l2Stream::Map(int buffers) {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(buffers);
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = device_.Control(VIDIOC_REQBUFS, &request); error != 0) Fail("asking for buffers", error);
  if (request.count == 0) throw CameraNotReady("the driver gives no buffers");
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = MakeBuffer(i);
    if (const int error = device_.Control(VIDIOC_QUERYBUF, &buffer); error != 0) Fail("asking for a buffer", error);
    void* address =
        v4l2_mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, device_.fd(), buffer.m.offset);
    if (address == MAP_FAILED) Fail("mapping a buffer", errno);
    mapped_.push_back({address, buffer.length});
  }
}

V4l2Stream::~V4l2Stream() {
  Stop();
  for (const Mapping& mapping : mapped_) v4l2_munmap(mapping.address, mapping.length);
}

int V4l2Stream::Queue(std::uint32_t index) {
  v4l2_buffer buffer = MakeBuffer(index);
  const int error = device_.Control(VIDIOC_QBUF, &buffer);
  if (error == 0) ++queued_;
  return error;
}

V4l2Stream::Dequeued V4l2Stream::Dequeue() {
  const std::lock_guard lock(mutex_);
  if (!streaming_) return {std::nullopt, ENODEV};
  v4l2_buffer buffer = MakeBuffer(0);
  if (const int error = device_.Control(VIDIOC_DQBUF, &buffer); error != 0) return {std::nullopt, error};
  if (buffer.index >= mapped_.size()) return {std::nullopt, EIO};
  --queued_;
  const Mapping& mapping = mapped_[buffer.index];
  V4l2Filled filled;
  filled.index = buffer.index;
  filled.bytes = {static_cast<const std::uint8_t*>(mapping.address),
                  std::min<std::size_t>(buffer.bytesused, mapping.length)};
  filled.sequence = buffer.sequence;
  filled.stamp = std::chrono::seconds(buffer.timestamp.tv_sec) + std::chrono::microseconds(buffer.timestamp.tv_usec);
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
    filled.clock = V4l2Clock::kMonotonic;
  // "End of frame" is when its last pixel was taken over from the sensor.
  const bool is_start = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  filled.instant = is_start ? ExposureInstant::kStart : ExposureInstant::kEnd;
  filled.is_damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
  return {filled, 0};
}

void V4l2Stream::Requeue(std::uint32_t index) {
  const std::lock_guard lock(mutex_);
  // A device that was unplugged refuses it; whoever waits for the next frame learns that.
  if (streaming_) Queue(index);
}

std::unique_ptr<FrameLease> V4l2Stream::Lend(std::uint32_t index) {
  return std::make_unique<StreamLease>(shared_from_this(), index);
}

int V4l2Stream::queued() const {
  const std::lock_guard lock(mutex_);
  return queued_;
}

void V4l2Stream::Stop() {
  const std::lock_guard lock(mutex_);
  if (!device_.is_open()) return;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (streaming_) device_.Control(VIDIOC_STREAMOFF, &type);
  streaming_ = false;
  device_ = V4l2Device();
}

}  // namespace chequer
