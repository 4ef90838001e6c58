#include "capture/v4l2_setup.h"

#include <linux/videodev2.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "capture/camera_trouble.h"
#include "capture/size_text.h"
#include "core/number_text.h"

namespace chequer {
namespace {

YuvRange RangeOf(const v4l2_pix_format& format) {
  const std::uint32_t range =
      format.quantization != V4L2_QUANTIZATION_DEFAULT
          ? format.quantization
          : std::uint32_t{V4L2_MAP_QUANTIZATION_DEFAULT(false, format.colorspace, format.ycbcr_enc)};
  return range == V4L2_QUANTIZATION_LIM_RANGE ? YuvRange::kLimited : YuvRange::kFull;
}

/// Sets one camera step by step.
class V4l2Setter {
 public:
  V4l2Setter(const V4l2Device& device, const std::string& node, const V4l2Options& options)
      : device_(device), node_(node), options_(options) {}

  V4l2SetUp Run() {
    if (options_.input) {
      int input = *options_.input;
      if (const int error = device_.Control(VIDIOC_S_INPUT, &input); error == EINVAL)
        throw std::runtime_error("capture.input = " + std::to_string(input) + ": " + node_ + " has no such input");
      else if (error != 0)
        throw CameraNotReady(std::string("choosing the input: ") + std::strerror(error));
    }
    SetFormat();
    SetRate();
    SetControls();
    return std::move(set_up_);
  }

 private:
  void SetFormat() {
    const CameraOptions& camera = options_.camera;
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (const int error = device_.Control(VIDIOC_G_FMT, &format); error != 0)
      throw CameraNotReady(std::string("the driver tells no format (yet): ") + std::strerror(error));
    const V4l2FormatChoice choice =
        ChooseV4l2Format(QueryFormats(device_), {camera.pixel_format, camera.width, camera.height, camera.fps},
                         static_cast<int>(format.fmt.pix.width), static_cast<int>(format.fmt.pix.height));
    const bool is_size = choice.wrong_key == V4l2FormatChoice::Key::kSize;
    const std::string& place = is_size ? camera.places.width : camera.places.pixel_format;
    if (!choice.wrong.empty()) throw std::runtime_error(place + ": " + node_ + ": " + choice.wrong);
    format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.pixelformat = choice.code;
    format.fmt.pix.width = static_cast<std::uint32_t>(choice.width);
    format.fmt.pix.height = static_cast<std::uint32_t>(choice.height);
    format.fmt.pix.field = V4L2_FIELD_NONE;
    if (const int error = device_.Control(VIDIOC_S_FMT, &format); error == EBUSY)
      throw CameraNotReady("another program uses the camera (fuser -v " + node_ + " names it)");
    else if (error != 0)
      throw CameraNotReady(std::string("setting the format: ") + std::strerror(error));
    TakeFormat(format.fmt.pix, choice, place);
  }

  /// @param got what the driver made of the choice.
  void TakeFormat(const v4l2_pix_format& got, const V4l2FormatChoice& choice, const std::string& place) {
    const CameraOptions& camera = options_.camera;
    const int width = static_cast<int>(got.width), height = static_cast<int>(got.height);
    if (got.pixelformat != choice.code || (camera.width && (width != choice.width || height != choice.height)))
      throw std::runtime_error(place + ": " + node_ + " was asked for " + SizeText(choice.width, choice.height) + " " +
                               NameOfFourCc(choice.code) + " and gives " + SizeText(width, height) + " " +
                               FourCcText(got.pixelformat) + "; chequer cameras lists what it offers");
    V4l2Layout& layout = set_up_.layout;
    layout = {got.pixelformat, width, height, static_cast<std::ptrdiff_t>(got.bytesperline),
              options_.yuv_range.value_or(RangeOf(got))};
    const auto pixels = PixelFormatOf(layout.code);
    if (pixels && layout.stride_bytes == 0) layout.stride_bytes = PlaneShapes(*pixels, width, height).front().row_bytes;
    if (pixels && (!SizeIsValid(*pixels, width, height) ||
                   layout.stride_bytes < PlaneShapes(*pixels, width, height).front().row_bytes))
      throw std::runtime_error(place + ": " + node_ + " gives " + SizeText(width, height) + " " +
                               NameOfFourCc(layout.code) + " with rows of " + std::to_string(layout.stride_bytes) +
                               " bytes, which cannot be; choose another format or size");
  }

  void SetRate() {
    const double wanted = options_.camera.fps;
    set_up_.rate_hz = wanted;
    v4l2_streamparm parameters{};
    parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    parameters.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(1000 * wanted))};
    const int error = device_.Control(VIDIOC_S_PARM, &parameters);
    const v4l2_fract& period = parameters.parm.capture.timeperframe;
    if (error != 0 || period.numerator == 0 || period.denominator == 0) {
      set_up_.remarks.push_back(options_.camera.places.fps + ": the driver lets nobody choose the rate");
      return;
    }
    set_up_.rate_hz = static_cast<double>(period.denominator) / static_cast<double>(period.numerator);
    if (std::abs(set_up_.rate_hz - wanted) > 0.01 * wanted)
      set_up_.remarks.push_back(options_.camera.places.fps + ": " + RoundText(wanted, 4) +
                                " frames/s were asked for, the camera gives " + RoundText(set_up_.rate_hz, 4));
  }

  void SetControls() {
    if (options_.camera.settings.empty()) return;
    std::vector<V4l2Control> controls = QueryControls(device_);
    const std::vector<CameraSetting> settings = InOrderOfSetting(controls, options_.camera.settings);
    for (const CameraSetting& setting : settings) {
      const V4l2Control& control = FindControl(controls, setting);
      const int error = SetControl(device_, control, ResolveControl(control, setting));
      if (error == ENODEV || error == EIO || error == EBUSY)
        throw CameraNotReady("setting " + control.name + ": " + std::strerror(error));
      if (error != 0)
        throw std::runtime_error(
            setting.place + ": the driver refuses it (" + std::strerror(error) + ")" +
            (control.is_inactive ? "; another control, such as an automatic one, governs it" : ""));
    }
    controls = QueryControls(device_);  // what is active changes with what was set
    for (const CameraSetting& setting : settings) {
      const V4l2Control& control = FindControl(controls, setting);
      const V4l2ControlValue wanted = ResolveControl(control, setting);
      const auto got = GetControl(device_, control);
      if (got && *got != wanted)
        set_up_.remarks.push_back(setting.place + ": the driver made it " + ControlValueText(control, *got));
      else if (control.is_inactive)
        set_up_.remarks.push_back(setting.place +
                                  ": has no effect now: another control, such as an automatic one, governs it");
    }
  }

  const V4l2Device& device_;
  const std::string& node_;
  const V4l2Options& options_;
  V4l2SetUp set_up_;
};

}  // namespace

V4l2SetUp SetUpV4l2(const V4l2Device& device, const std::string& node, const V4l2Options& options) {
  return V4l2Setter(device, node, options).Run();
}

}  // namespace chequer
