#include "capture/v4l2_source.h"

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "capture/camera_trouble.h"
#include "capture/jpeg.h"
#include "capture/size_text.h"
#include "core/number_text.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// How long a node may be forbidden: when a camera is plugged in, its node is there for a moment before udev gives it
/// to its group.
constexpr std::chrono::seconds kForbiddenGrace{3};

/// The node that any other link leads to, such as one of a udev rule of one's own.
std::string NodeOfLink(const std::string& device) {
  if (!device.starts_with('/') || device.starts_with(kStableLinks)) return device;
  std::error_code error;
  const std::filesystem::path node = std::filesystem::canonical(device, error);
  return error ? device : node.string();
}

}  // namespace

V4l2Source::V4l2Source(V4l2Options options, V4l2Roots roots, Clock clock)
    : options_(std::move(options)),
      roots_(std::move(roots)),
      clock_(std::move(clock)),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_.valid()) throw std::system_error(errno, std::generic_category(), "eventfd");
}

V4l2Source::~V4l2Source() { Close(); }

void V4l2Source::Close() {
  if (stream_) stream_->Stop();
  stream_.reset();
}

void V4l2Source::Interrupt() { eventfd_write(wake_.get(), 1); }

std::string V4l2Source::Open() {
  Close();
  remarks_.clear();
  try {
    V4l2Device device = OpenDevice();
    V4l2SetUp set_up = SetUpV4l2(device, node_->path, options_);
    layout_ = set_up.layout;
    rate_hz_ = set_up.rate_hz;
    remarks_ = std::move(set_up.remarks);
    stream_ = V4l2Stream::Start(std::move(device), options_.camera.buffers);
  } catch (const CameraNotReady& trouble) {
    return (node_ ? node_->path + " (" + node_->name + "): " : std::string()) + trouble.what();
  }
  silence_.Opened(microseconds(std::llround(1e6 / rate_hz_)), clock_.monotonic());
  return {};
}

V4l2Device V4l2Source::OpenDevice() {
  const std::string& place = options_.camera.places.device;
  const std::vector<V4l2Node> nodes = ListV4l2Nodes(roots_);
  V4l2Found found = FindV4l2Node(nodes, NodeOfLink(options_.camera.device), place, node_);
  if (!found.node) throw CameraNotReady(found.problem);
  try {
    V4l2Device device(found.node->path);
    const V4l2Capability capability = QueryCapability(device);
    if (!capability.captures)
      throw std::runtime_error(place + ": " + found.node->path + " (" + found.node->name +
                               ") gives no frames: it is no capture device, or not the node of the camera that is one");
    must_copy_ = capability.driver == "v4l2 loopback";
    forbidden_since_.reset();
    node_ = std::move(found.node);
    return device;
  } catch (const std::system_error& forbidden) {
    const std::string message = place + ": " + std::string(forbidden.what()) +
                                ": add the user that runs this to the group of the device (usually: usermod -aG video "
                                "USER, then log in anew)";
    if (!forbidden_since_) forbidden_since_ = clock_.monotonic();
    if (clock_.monotonic() - *forbidden_since_ < kForbiddenGrace) throw CameraNotReady(message);
    throw std::runtime_error(message);
  }
}

V4l2Source::Woken V4l2Source::Wait(microseconds time) const {
  std::array<pollfd, 2> waiting{{{stream_->device().fd(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
  const auto wait = std::chrono::ceil<milliseconds>(std::max(time, microseconds(0)));
  if (poll(waiting.data(), waiting.size(), static_cast<int>(wait.count())) <= 0) return Woken::kByTime;
  eventfd_t count = 0;
  if (waiting[1].revents != 0 && eventfd_read(wake_.get(), &count) == 0) return Woken::kByInterrupt;
  return (waiting[0].revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 ? Woken::kByError : Woken::kByFrame;
}

CaptureResult V4l2Source::Lost(const std::string& why) {
  Close();
  return {CaptureStatus::kDisconnected, {}, node_->path + " (" + node_->name + "): " + why};
}

CaptureResult V4l2Source::Next(milliseconds timeout) {
  if (!stream_) return {CaptureStatus::kDisconnected, {}, "the camera is not open"};
  const MonotonicTime deadline = clock_.monotonic() + timeout;
  Woken woken = Woken::kByTime;
  while (true) {
    const V4l2Stream::Dequeued dequeued = stream_->Dequeue();
    const MonotonicTime now = clock_.monotonic();
    if (dequeued.filled) {
      silence_.Alive(now);
      return Take(*dequeued.filled);
    }
    if (dequeued.error == EAGAIN && woken == Woken::kByError) return Lost("the driver reports an error");
    if (dequeued.error != EAGAIN) return Lost(std::strerror(dequeued.error));
    // While frames that are under way hold every buffer, the camera cannot deliver.
    if (stream_->queued() == 0) silence_.Alive(now, false);
    if (silence_.IsSilent(now)) return Lost(silence_.Message(now));
    if (now >= deadline) return {CaptureStatus::kTimeout, {}, {}};
    woken = Wait(std::min(deadline - now, silence_.Left(now)));
    if (woken == Woken::kByInterrupt) return {CaptureStatus::kTimeout, {}, {}};
  }
}

CaptureResult V4l2Source::Take(const V4l2Filled& filled) {
  // The driver counts in 32 bits.
  const auto step = filled.sequence - static_cast<std::uint32_t>(sequence_);
  sequence_ = step < 1u << 31 ? sequence_ + step : filled.sequence;
  CaptureResult result;
  if (filled.is_damaged) {
    result = {CaptureStatus::kCorrupt, {}, "the driver marked frame " + std::to_string(sequence_) + " as damaged"};
  } else {
    result = IsJpeg(layout_.code) ? TakeJpeg(filled) : TakeRaw(filled);
  }
  if (result.status != CaptureStatus::kFrame) {
    stream_->Requeue(filled.index);
    return result;
  }
  const V4l2FrameTimes times =
      MapV4l2Times(filled.stamp, filled.clock, filled.instant, {clock_.monotonic(), clock_.utc()});
  result.frame.captured_monotonic = times.monotonic;
  result.frame.captured_utc = times.utc;
  result.frame.instant = times.instant;
  result.frame.sequence = sequence_;
  return result;
}

std::optional<ImageView> V4l2Source::View(std::span<const std::uint8_t> bytes) const {
  const PixelFormat format = *PixelFormatOf(layout_.code);
  const auto shapes = PlaneShapes(format, layout_.width, layout_.height);
  std::array<Plane, 3> planes;
  std::ptrdiff_t at = 0;
  for (std::size_t i = 0; i < planes.size() && shapes[i].rows > 0; ++i) {
    // Of planar formats the chroma planes have their share of the first one's stride.
    const std::ptrdiff_t stride = layout_.stride_bytes * shapes[i].row_bytes / shapes[0].row_bytes;
    planes[i] = {bytes.data() + at, stride};
    at += stride * shapes[i].rows;
  }
  // Drivers leave out the padding of the last row.
  const std::ptrdiff_t padding = layout_.stride_bytes - shapes[0].row_bytes;
  if (static_cast<std::ptrdiff_t>(bytes.size()) + padding < at) return std::nullopt;
  return ImageView(format, layout_.width, layout_.height, planes, options_.camera.tone_curve,
                   IsYuv(format) ? layout_.range : YuvRange::kFull);
}

CaptureResult V4l2Source::TakeRaw(const V4l2Filled& filled) {
  const auto view = View(filled.bytes);
  if (!view)
    return {CaptureStatus::kCorrupt, {}, "only " + std::to_string(filled.bytes.size()) + " bytes of a frame came"};
  CaptureResult result;
  result.status = CaptureStatus::kFrame;
  if (stream_->queued() > 0 && !must_copy_) {
    result.frame.image = *view;
    result.frame.lease = stream_->Lend(filled.index);
    return result;
  }
  Image copy = pool_->Take();
  CopyPixels(*view, copy);
  result.frame.image = copy.view();
  result.frame.lease = pool_->Lend(std::move(copy));
  stream_->Requeue(filled.index);
  return result;
}

CaptureResult V4l2Source::TakeJpeg(const V4l2Filled& filled) {
  CaptureResult result;
  try {
    Image image = pool_->Take();
    DecodeJpeg(filled.bytes, JpegColour::kYuv, options_.camera.tone_curve, image);
    if (image.width() != layout_.width || image.height() != layout_.height)
      return {CaptureStatus::kCorrupt, {}, "a frame of " + SizeText(image.width(), image.height()) + " came"};
    result.status = CaptureStatus::kFrame;
    result.frame.image = image.view();
    result.frame.lease = pool_->Lend(std::move(image));
  } catch (const std::runtime_error& error) {
    return {CaptureStatus::kCorrupt, {}, std::string("a JPEG cannot be decoded: ") + error.what()};
  }
  stream_->Requeue(filled.index);
  return result;
}

std::string V4l2Source::Describe() const {
  if (!node_) return "camera " + (options_.camera.device.empty() ? std::string("of V4L2") : options_.camera.device);
  if (!stream_) return "camera " + node_->path + " (" + node_->name + ")";
  return "camera " + node_->path + " (" + node_->name + "), " + SizeText(layout_.width, layout_.height) + " " +
         NameOfFourCc(layout_.code) + ", " + RoundText(rate_hz_, 4) + " fps";
}

}  // namespace chequer
