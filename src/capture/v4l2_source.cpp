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
#include "core/number_text.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// How long a node may be forbidden: when a camera is plugged in, its node is there for a moment before udev gives it
/// to its group.
constexpr std::chrono::seconds kForbiddenGrace{3};

std::string SizeText(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

/// The node that any other link leads to, such as one of a udev rule of one's own.
std::string NodeOfLink(const std::string& device) {
  if (!device.starts_with('/') || device.starts_with(kStableLinks)) return device;
  std::error_code error;
  const std::filesystem::path node = std::filesystem::canonical(device, error);
  return error ? device : node.string();
}

YuvRange RangeOf(const v4l2_pix_format& format) {
  const std::uint32_t range =
      format.quantization != V4L2_QUANTIZATION_DEFAULT
          ? format.quantization
          : std::uint32_t{V4L2_MAP_QUANTIZATION_DEFAULT(false, format.colorspace, format.ycbcr_enc)};
  return range == V4L2_QUANTIZATION_LIM_RANGE ? YuvRange::kLimited : YuvRange::kFull;
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
    SetUp(device);
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

void V4l2Source::SetUp(const V4l2Device& device) {
  if (options_.input) {
    int input = *options_.input;
    if (const int error = device.Control(VIDIOC_S_INPUT, &input); error == EINVAL)
      throw std::runtime_error("capture.input = " + std::to_string(input) + ": " + node_->path + " has no such input");
    else if (error != 0)
      throw CameraNotReady(std::string("choosing the input: ") + std::strerror(error));
  }
  SetFormat(device);
  SetRate(device);
  SetControls(device);
}

void V4l2Source::SetFormat(const V4l2Device& device) {
  const CameraOptions& camera = options_.camera;
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = device.Control(VIDIOC_G_FMT, &format); error != 0)
    throw CameraNotReady(std::string("the driver tells no format (yet): ") + std::strerror(error));
  const V4l2FormatChoice choice =
      ChooseV4l2Format(QueryFormats(device), {camera.pixel_format, camera.width, camera.height, camera.fps},
                       static_cast<int>(format.fmt.pix.width), static_cast<int>(format.fmt.pix.height));
  const bool is_size = choice.wrong_key == V4l2FormatChoice::Key::kSize;
  const std::string& place = is_size ? camera.places.width : camera.places.pixel_format;
  if (!choice.wrong.empty()) throw std::runtime_error(place + ": " + node_->path + ": " + choice.wrong);
  format = {};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.pixelformat = choice.code;
  format.fmt.pix.width = static_cast<std::uint32_t>(choice.width);
  format.fmt.pix.height = static_cast<std::uint32_t>(choice.height);
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (const int error = device.Control(VIDIOC_S_FMT, &format); error == EBUSY)
    throw CameraNotReady("another program uses the camera (fuser -v " + node_->path + " names it)");
  else if (error != 0)
    throw CameraNotReady(std::string("setting the format: ") + std::strerror(error));
  const v4l2_pix_format& got = format.fmt.pix;
  const int width = static_cast<int>(got.width), height = static_cast<int>(got.height);
  if (got.pixelformat != choice.code || (camera.width && (width != choice.width || height != choice.height)))
    throw std::runtime_error(place + ": " + node_->path + " was asked for " + SizeText(choice.width, choice.height) +
                             " " + NameOfFourCc(choice.code) + " and gives " + SizeText(width, height) + " " +
                             FourCcText(got.pixelformat) + "; chequer cameras lists what it offers");
  layout_ = {got.pixelformat, width, height, static_cast<std::ptrdiff_t>(got.bytesperline),
             options_.yuv_range.value_or(RangeOf(got))};
  const auto pixels = PixelFormatOf(layout_.code);
  if (pixels && layout_.stride_bytes == 0) layout_.stride_bytes = PlaneShapes(*pixels, width, height).front().row_bytes;
  if (pixels && (!SizeIsValid(*pixels, width, height) ||
                 layout_.stride_bytes < PlaneShapes(*pixels, width, height).front().row_bytes))
    throw std::runtime_error(place + ": " + node_->path + " gives " + SizeText(width, height) + " " +
                             NameOfFourCc(layout_.code) + " with rows of " + std::to_string(layout_.stride_bytes) +
                             " bytes, which cannot be; choose another format or size");
}

void V4l2Source::SetRate(const V4l2Device& device) {
  const double wanted = options_.camera.fps;
  rate_hz_ = wanted;
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  parameters.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(1000 * wanted))};
  const int error = device.Control(VIDIOC_S_PARM, &parameters);
  const v4l2_fract& period = parameters.parm.capture.timeperframe;
  if (error != 0 || period.numerator == 0 || period.denominator == 0) {
    remarks_.push_back(options_.camera.places.fps + ": the driver lets nobody choose the rate");
    return;
  }
  rate_hz_ = static_cast<double>(period.denominator) / static_cast<double>(period.numerator);
  if (std::abs(rate_hz_ - wanted) > 0.01 * wanted)
    remarks_.push_back(options_.camera.places.fps + ": " + RoundText(wanted, 4) +
                       " frames/s were asked for, the camera gives " + RoundText(rate_hz_, 4));
}

void V4l2Source::SetControls(const V4l2Device& device) {
  if (options_.camera.settings.empty()) return;
  std::vector<V4l2Control> controls = QueryControls(device);
  const std::vector<CameraSetting> settings = InOrderOfSetting(controls, options_.camera.settings);
  for (const CameraSetting& setting : settings) {
    const V4l2Control& control = FindControl(controls, setting);
    const int error = SetControl(device, control, ResolveControl(control, setting));
    if (error == ENODEV || error == EIO || error == EBUSY)
      throw CameraNotReady("setting " + control.name + ": " + std::strerror(error));
    if (error != 0)
      throw std::runtime_error(setting.place + ": the driver refuses it (" + std::strerror(error) + ")" +
                               (control.is_inactive ? "; another control, such as an automatic one, governs it" : ""));
  }
  controls = QueryControls(device);  // what is active changes with what was set
  for (const CameraSetting& setting : settings) {
    const V4l2Control& control = FindControl(controls, setting);
    const V4l2ControlValue wanted = ResolveControl(control, setting);
    const auto got = GetControl(device, control);
    if (got && *got != wanted)
      remarks_.push_back(setting.place + ": the driver made it " + ControlValueText(control, *got));
    else if (control.is_inactive)
      remarks_.push_back(setting.place + ": has no effect now: another control, such as an automatic one, governs it");
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
