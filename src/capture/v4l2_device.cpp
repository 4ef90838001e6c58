#include "capture/v4l2_device.h"

#include <fcntl.h>
#include <libv4l2.h>
#include <linux/videodev2.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <optional>
#include <system_error>
#include <utility>

#include "capture/camera_trouble.h"

namespace chequer {
namespace {

/// More than any driver has; a broken one could count on for ever.
constexpr std::uint32_t kMostItems = 1000;

template <std::size_t size>
std::string Text(const std::uint8_t (&bytes)[size]) {
  const auto* end = std::find(bytes, bytes + size, std::uint8_t{0});
  return {bytes, end};
}

double Rate(const v4l2_fract& period) {
  return period.numerator == 0 ? 0 : static_cast<double>(period.denominator) / static_cast<double>(period.numerator);
}

std::vector<double> QueryRates(const V4l2Device& device, FourCc code, std::uint32_t width, std::uint32_t height) {
  std::vector<double> rates;
  for (std::uint32_t i = 0; i < kMostItems; ++i) {
    v4l2_frmivalenum interval{};
    interval.index = i;
    interval.pixel_format = code;
    interval.width = width;
    interval.height = height;
    if (device.Control(VIDIOC_ENUM_FRAMEINTERVALS, &interval) != 0) break;
    if (interval.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      rates.push_back(Rate(interval.discrete));
      continue;
    }
    rates = {Rate(interval.stepwise.min), Rate(interval.stepwise.max)};
    break;
  }
  std::sort(rates.begin(), rates.end(), std::greater<>());
  rates.erase(std::unique(rates.begin(), rates.end()), rates.end());
  return rates;
}

std::vector<V4l2SizeOffer> QuerySizes(const V4l2Device& device, FourCc code) {
  std::vector<V4l2SizeOffer> sizes;
  const auto number = [](std::uint32_t value) { return static_cast<int>(std::min<std::uint32_t>(value, 1u << 20)); };
  for (std::uint32_t i = 0; i < kMostItems; ++i) {
    v4l2_frmsizeenum size{};
    size.index = i;
    size.pixel_format = code;
    if (device.Control(VIDIOC_ENUM_FRAMESIZES, &size) != 0) break;
    if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      const int width = number(size.discrete.width), height = number(size.discrete.height);
      sizes.push_back(
          {width, width, 1, height, height, 1, QueryRates(device, code, size.discrete.width, size.discrete.height)});
      continue;
    }
    const v4l2_frmsize_stepwise& range = size.stepwise;
    sizes.push_back({number(range.min_width), number(range.max_width), number(range.step_width),
                     number(range.min_height), number(range.max_height), number(range.step_height),
                     QueryRates(device, code, range.max_width, range.max_height)});
    break;
  }
  return sizes;
}

V4l2ControlKind KindOfControl(std::uint32_t type) {
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_INTEGER64: return V4l2ControlKind::kInteger;
    case V4L2_CTRL_TYPE_BOOLEAN: return V4l2ControlKind::kBoolean;
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU: return V4l2ControlKind::kMenu;
    case V4L2_CTRL_TYPE_BUTTON: return V4l2ControlKind::kButton;
    case V4L2_CTRL_TYPE_BITMASK: return V4l2ControlKind::kBitmask;
    case V4L2_CTRL_TYPE_STRING: return V4l2ControlKind::kString;
    default: return V4l2ControlKind::kOther;
  }
}

void QueryMenu(const V4l2Device& device, bool of_numbers, V4l2Control& control) {
  const std::int64_t last = std::min<std::int64_t>(control.max, kMostItems);
  for (std::int64_t i = std::max<std::int64_t>(control.min, 0); i <= last; ++i) {
    v4l2_querymenu item{};
    item.id = control.id;
    item.index = static_cast<std::uint32_t>(i);
    if (device.Control(VIDIOC_QUERYMENU, &item) != 0) continue;  // a menu may have gaps
    control.menu.emplace_back(i, of_numbers ? std::to_string(item.value) : Text(item.name));
  }
}

/// Room for the value of a control, as the kernel wants it.
struct ExtendedControl {
  explicit ExtendedControl(const V4l2Control& of)
      : text(of.kind == V4l2ControlKind::kString
                 ? static_cast<std::size_t>(std::clamp<std::int64_t>(of.max, 0, 65535)) + 1
                 : 0) {
    control.id = of.id;
    if (!text.empty()) {
      control.size = static_cast<std::uint32_t>(text.size());
      control.string = text.data();
    }
    all.which = V4L2_CTRL_WHICH_CUR_VAL;
    all.count = 1;
    all.controls = &control;
  }
  ExtendedControl(const ExtendedControl&) = delete;

  std::vector<char> text;  ///< zero-terminated
  v4l2_ext_control control{};
  v4l2_ext_controls all{};
};

}  // namespace

V4l2Device::V4l2Device(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    const int error = errno;
    if (error == EACCES || error == EPERM) throw std::system_error(error, std::generic_category(), path);
    throw CameraNotReady(path + " cannot be opened: " + std::strerror(error));
  }
  struct stat status {};
  const bool is_device = fstat(fd, &status) == 0 && S_ISCHR(status.st_mode);
  fd_ = is_device ? v4l2_fd_open(fd, V4L2_DISABLE_CONVERSION) : -1;
  if (fd_ >= 0) return;
  const int error = errno;
  ::close(fd);
  if (is_device && (error == ENODEV || error == EBUSY))
    throw CameraNotReady(path + " cannot be opened: " + std::strerror(error));
  if (is_device && error == EINVAL)  // what a loop says whose feeder is not there yet
    throw CameraNotReady(path + " gives no frames (yet): it takes no part in capturing now");
  throw std::runtime_error(path + " is not a camera of V4L2");
}

V4l2Device::V4l2Device(V4l2Device&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

V4l2Device& V4l2Device::operator=(V4l2Device&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

V4l2Device::~V4l2Device() {
  if (fd_ >= 0) v4l2_close(fd_);
}

int V4l2Device::Control(unsigned long request, void* argument) const {
  while (v4l2_ioctl(fd_, request, argument) < 0)
    if (errno != EINTR) return errno;
  return 0;
}

V4l2Capability QueryCapability(const V4l2Device& device) {
  v4l2_capability capability{};
  if (const int error = device.Control(VIDIOC_QUERYCAP, &capability); error != 0)
    throw CameraNotReady(std::string("the driver does not answer: ") + std::strerror(error));
  const std::uint32_t here =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  return {Text(capability.driver), Text(capability.card), Text(capability.bus_info),
          (here & V4L2_CAP_VIDEO_CAPTURE) != 0 && (here & V4L2_CAP_STREAMING) != 0};
}

std::vector<V4l2FormatOffer> QueryFormats(const V4l2Device& device) {
  std::vector<V4l2FormatOffer> offers;
  for (std::uint32_t i = 0; i < kMostItems; ++i) {
    v4l2_fmtdesc format{};
    format.index = i;
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (device.Control(VIDIOC_ENUM_FMT, &format) != 0) break;
    offers.push_back({format.pixelformat, Text(format.description), QuerySizes(device, format.pixelformat)});
  }
  return offers;
}

std::vector<V4l2Control> QueryControls(const V4l2Device& device) {
  std::vector<V4l2Control> controls;
  v4l2_query_ext_ctrl query{};
  for (std::uint32_t i = 0; i < kMostItems; ++i) {
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
    if (device.Control(VIDIOC_QUERY_EXT_CTRL, &query) != 0) break;
    const bool is_heading = query.type == V4L2_CTRL_TYPE_CTRL_CLASS;
    if (is_heading || (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0) continue;
    V4l2Control control;
    control.id = query.id;
    control.name = ControlName(query.name);
    control.kind = KindOfControl(query.type);
    control.min = query.minimum;
    control.max = query.maximum;
    control.step = static_cast<std::int64_t>(query.step);
    control.default_value = query.default_value;
    control.is_wide = query.type == V4L2_CTRL_TYPE_INTEGER64;
    control.is_read_only = (query.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0;
    control.is_inactive = (query.flags & (V4L2_CTRL_FLAG_INACTIVE | V4L2_CTRL_FLAG_GRABBED)) != 0;
    if (control.kind == V4l2ControlKind::kMenu) QueryMenu(device, query.type == V4L2_CTRL_TYPE_INTEGER_MENU, control);
    controls.push_back(std::move(control));
  }
  return controls;
}

int SetControl(const V4l2Device& device, const V4l2Control& control, const V4l2ControlValue& value) {
  ExtendedControl extended(control);
  if (const auto* text = std::get_if<std::string>(&value)) {
    std::copy_n(text->begin(), std::min(text->size(), extended.text.size() - 1), extended.text.begin());
  } else if (control.is_wide) {
    extended.control.value64 = std::get<std::int64_t>(value);
  } else {
    extended.control.value = static_cast<std::int32_t>(std::get<std::int64_t>(value));
  }
  return device.Control(VIDIOC_S_EXT_CTRLS, &extended.all);
}

std::optional<V4l2ControlValue> GetControl(const V4l2Device& device, const V4l2Control& control) {
  if (control.kind == V4l2ControlKind::kOther || control.kind == V4l2ControlKind::kButton) return std::nullopt;
  ExtendedControl extended(control);
  if (device.Control(VIDIOC_G_EXT_CTRLS, &extended.all) != 0) return std::nullopt;
  if (!extended.text.empty()) return V4l2ControlValue(std::string(extended.text.data()));
  if (control.is_wide) return V4l2ControlValue(static_cast<std::int64_t>(extended.control.value64));
  // A mask has 32 bits and no sign.
  if (control.kind == V4l2ControlKind::kBitmask)
    return V4l2ControlValue(static_cast<std::int64_t>(static_cast<std::uint32_t>(extended.control.value)));
  return V4l2ControlValue(static_cast<std::int64_t>(extended.control.value));
}

}  // namespace chequer
