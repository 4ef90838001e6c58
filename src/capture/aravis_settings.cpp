#include "capture/aravis_settings.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "capture/aravis_features.h"
#include "capture/aravis_formats.h"
#include "core/number_text.h"

namespace chequer {
namespace {

template <typename Number>
std::string Option(const char* key, Number value) {
  return std::string("capture.") + key + " = " + RoundText(static_cast<double>(value));
}

const char* NameOf(AutoMode mode) {
  switch (mode) {
    case AutoMode::kOff: return "Off";
    case AutoMode::kOnce: return "Once";
    case AutoMode::kContinuous: return "Continuous";
  }
  return "Off";
}

const char* WordOf(AutoMode mode) {
  switch (mode) {
    case AutoMode::kOff: return "off";
    case AutoMode::kOnce: return "once";
    case AutoMode::kContinuous: return "continuous";
  }
  return "off";
}

/// Sets one camera step by step.
class AravisSetter {
 public:
  AravisSetter(ArvCamera* camera, const AravisOptions& options)
      : camera_(camera), device_(arv_camera_get_device(camera)), options_(options) {}

  AravisSetUp Run() {
    SetFormat();
    SetBinning();
    SetRegion();
    SetExposure();
    SetGain();
    SetWhiteBalance();
    SetTrigger();
    SetTransport();
    for (const CameraSetting& setting : options_.camera.settings) Tell(setting.place, SetFeature(device_, setting));
    if (options_.trigger == TriggerKind::kFree) ReadRate();
    return std::move(set_up_);
  }

 private:
  bool Has(const char* feature) const { return arv_device_is_feature_available(device_, feature, nullptr) != 0; }

  [[noreturn]] static void Refuse(const std::string& place, const std::string& why) {
    throw std::runtime_error(place + ": " + why);
  }

  void Require(const char* feature, const std::string& place) const {
    if (!Has(feature)) Refuse(place, std::string("the camera has no ") + feature);
  }

  void Remark(const std::string& place, const std::string& what) { set_up_.remarks.push_back(place + ": " + what); }
  /// @param altered AlteredText.
  void Tell(const std::string& place, const std::string& altered) {
    if (!altered.empty()) Remark(place, altered);
  }

  void SetFormat() {
    const GenicamFormatChoice choice = ChooseGenicamFormat(GenicamFormats(camera_), options_.camera.pixel_format);
    const std::string& place = options_.camera.places.pixel_format;
    if (!choice.wrong.empty()) Refuse(place, choice.wrong);
    arv_camera_set_pixel_format_from_string(camera_, choice.name.c_str(), error_.Receive());
    error_.Check(place);
  }

  void SetBinning() {
    if (!options_.binning_x && !options_.binning_y) return;
    const std::string place =
        options_.binning_x ? Option("binning_x", *options_.binning_x) : Option("binning_y", *options_.binning_y);
    if (arv_camera_is_binning_available(camera_, nullptr) == 0) Refuse(place, "the camera has no binning");
    CheckRange(place, "BinningHorizontal", options_.binning_x.value_or(1));
    CheckRange(place, "BinningVertical", options_.binning_y.value_or(1));
    arv_camera_set_binning(camera_, options_.binning_x.value_or(1), options_.binning_y.value_or(1), error_.Receive());
    error_.Check(place);
  }

  /// Refuses what an integer feature does not allow.
  void CheckRange(const std::string& place, const char* feature, std::int64_t value) {
    gint64 min = 0, max = 0;
    arv_device_get_integer_feature_bounds(device_, feature, &min, &max, error_.Receive());
    if (error_.is_set()) return;  // it does not say
    const gint64 step = std::max<gint64>(arv_device_get_integer_feature_increment(device_, feature, nullptr), 1);
    if (value < min || value > max || (value - min) % step != 0)
      Refuse(place, std::string("the camera's ") + feature + " goes from " + std::to_string(min) + " to " +
                        std::to_string(max) + (step > 1 ? " in steps of " + std::to_string(step) : ""));
  }

  void SetRegion() {
    const CameraOptions& camera = options_.camera;
    if (!camera.width && !options_.offset_x && !options_.offset_y) return;
    gint x = 0, y = 0, width = 0, height = 0;
    arv_camera_get_region(camera_, &x, &y, &width, &height, error_.Receive());
    error_.Check("reading the region");
    if (camera.width) {
      // Offsets limit the size that is left.
      if (arv_camera_is_region_offset_available(camera_, nullptr) != 0)
        arv_camera_set_region(camera_, 0, 0, -1, -1, nullptr);
      CheckRange(camera.places.width, "Width", *camera.width);
      CheckRange(Option("height", *camera.height), "Height", *camera.height);
      width = *camera.width, height = *camera.height;
    }
    x = options_.offset_x.value_or(camera.width ? 0 : x);
    y = options_.offset_y.value_or(camera.width ? 0 : y);
    arv_camera_set_region(camera_, -1, -1, width, height, error_.Receive());
    error_.Check(camera.places.width);
    if (options_.offset_x) CheckRange(Option("offset_x", x), "OffsetX", x);
    if (options_.offset_y) CheckRange(Option("offset_y", y), "OffsetY", y);
    if (x != 0 || y != 0 || options_.offset_x || options_.offset_y) {
      arv_camera_set_region(camera_, x, y, -1, -1, error_.Receive());
      error_.Check(options_.offset_x ? Option("offset_x", x) : Option("offset_y", y));
    }
    gint got_width = 0, got_height = 0;
    arv_camera_get_region(camera_, &x, &y, &got_width, &got_height, error_.Receive());
    error_.Check("reading the region");
    if (got_width != width || got_height != height)
      Refuse(camera.places.width, "the camera gives " + std::to_string(got_width) + "x" + std::to_string(got_height) +
                                      " instead of " + std::to_string(width) + "x" + std::to_string(height));
  }

  void SetAuto(const char* feature, const char* key, AutoMode mode) {
    const std::string place = std::string("capture.") + key + " = '" + WordOf(mode) + "'";
    // A camera that never adjusts by itself is switched off already.
    if (!Has(feature) && mode == AutoMode::kOff) return;
    Require(feature, place);
    arv_device_set_string_feature_value(device_, feature, NameOf(mode), error_.Receive());
    error_.Check(place + " (" + feature + " allows " + AllowedByFeature(device_, feature) + ")");
  }

  static void CheckBounds(const std::string& place, double value, double min, double max) {
    if (value < min || value > max) Refuse(place, "the camera allows from " + RoundText(min) + " to " + RoundText(max));
  }

  void SetExposure() {
    if (options_.exposure_auto) SetAuto("ExposureAuto", "exposure_auto", *options_.exposure_auto);
    if (!options_.exposure_us) return;
    const double wanted = *options_.exposure_us;
    const std::string place = Option("exposure_us", wanted);
    if (arv_camera_is_exposure_time_available(camera_, nullptr) == 0) Refuse(place, "the camera has no exposure time");
    if (!options_.exposure_auto && arv_camera_is_exposure_auto_available(camera_, nullptr) != 0)
      arv_camera_set_exposure_time_auto(camera_, ARV_AUTO_OFF, nullptr);
    double min = 0, max = 0;
    arv_camera_get_exposure_time_bounds(camera_, &min, &max, error_.Receive());
    if (!error_.is_set()) CheckBounds(place, wanted, min, max);
    arv_camera_set_exposure_time(camera_, wanted, error_.Receive());
    error_.Check(place);
    Tell(place, AlteredText(wanted, arv_camera_get_exposure_time(camera_, nullptr)));
  }

  void SetGain() {
    if (options_.gain_auto) SetAuto("GainAuto", "gain_auto", *options_.gain_auto);
    if (!options_.gain) return;
    const double wanted = *options_.gain;
    const std::string place = Option("gain", wanted);
    if (arv_camera_is_gain_available(camera_, nullptr) == 0) Refuse(place, "the camera has no gain");
    if (!options_.gain_auto && arv_camera_is_gain_auto_available(camera_, nullptr) != 0)
      arv_camera_set_gain_auto(camera_, ARV_AUTO_OFF, nullptr);
    double min = 0, max = 0;
    arv_camera_get_gain_bounds(camera_, &min, &max, error_.Receive());
    if (!error_.is_set()) CheckBounds(place, wanted, min, max);
    arv_camera_set_gain(camera_, wanted, error_.Receive());
    error_.Check(place);
    Tell(place, AlteredText(wanted, arv_camera_get_gain(camera_, nullptr)));
  }

  void SetWhiteBalance() {
    if (options_.white_balance_auto) SetAuto("BalanceWhiteAuto", "white_balance_auto", *options_.white_balance_auto);
    if (options_.balance_red) SetBalance("Red", "balance_red", *options_.balance_red);
    if (options_.balance_blue) SetBalance("Blue", "balance_blue", *options_.balance_blue);
  }

  void SetBalance(const char* colour, const char* key, double ratio) {
    const std::string place = Option(key, ratio);
    const char* feature = Has("BalanceRatioAbs") ? "BalanceRatioAbs" : "BalanceRatio";
    Require(feature, place);
    arv_device_set_string_feature_value(device_, "BalanceRatioSelector", colour, error_.Receive());
    error_.Check(place);
    double min = 0, max = 0;
    arv_device_get_float_feature_bounds(device_, feature, &min, &max, error_.Receive());
    if (!error_.is_set()) CheckBounds(place, ratio, min, max);
    arv_device_set_float_feature_value(device_, feature, ratio, error_.Receive());
    error_.Check(place);
    Tell(place, AlteredText(ratio, arv_device_get_float_feature_value(device_, feature, nullptr)));
  }

  void SetTrigger() {
    arv_camera_set_acquisition_mode(camera_, ARV_ACQUISITION_MODE_CONTINUOUS, error_.Receive());
    if (error_.may_pass()) error_.Check("setting the acquisition mode");
    switch (options_.trigger) {
      case TriggerKind::kFree: return SetRate();
      case TriggerKind::kSoftware:
        if (arv_camera_is_software_trigger_supported(camera_, nullptr) == 0)
          Refuse("capture.trigger = 'software'", "the camera has no software trigger");
        set_up_.rate_hz = options_.camera.fps;
        return SetTriggerSource("Software", "capture.trigger = 'software'");
      case TriggerKind::kHardware:
        return SetTriggerSource(options_.trigger_line.c_str(),
                                "capture.trigger_line = '" + options_.trigger_line + "'");
    }
  }

  void SetTriggerSource(const char* source, const std::string& place) {
    Require("TriggerSource", place);
    const std::vector<std::string> sources = TriggerSources(camera_, error_);
    if (!error_.is_set() && std::find(sources.begin(), sources.end(), source) == sources.end())
      Refuse(place, "the camera's trigger sources are " + JoinedWithOr(sources));
    arv_camera_set_trigger(camera_, source, error_.Receive());
    error_.Check(place);
  }

  void SetRate() {
    const double wanted = options_.camera.fps;
    set_up_.rate_hz = wanted;
    if (arv_camera_is_frame_rate_available(camera_, nullptr) == 0) {
      arv_camera_clear_triggers(camera_, nullptr);
      return Remark(options_.camera.places.fps, "the camera lets nobody choose the rate");
    }
    arv_camera_set_frame_rate(camera_, wanted, error_.Receive());  // keeps it within the bounds, and triggers off
    error_.Check(options_.camera.places.fps);
  }

  /// Last, because exposure and region limit the rate.
  void ReadRate() {
    const double got = arv_camera_get_frame_rate(camera_, error_.Receive());
    if (error_.is_set() || got <= 0) return;
    if (std::abs(got - options_.camera.fps) > 0.01 * options_.camera.fps)
      Remark(options_.camera.places.fps,
             RoundText(options_.camera.fps) + " frames/s were asked for, the camera gives " + RoundText(got));
    set_up_.rate_hz = got;
  }

  void SetTransport() {
    if (options_.ptp) {
      const char* feature = Has("PtpEnable") ? "PtpEnable" : "GevIEEE1588";
      Require(feature, "capture.ptp = true");
      arv_device_set_boolean_feature_value(device_, feature, 1, error_.Receive());
      error_.Check("capture.ptp = true");
    }
    if (arv_camera_is_gv_device(camera_) == 0) return;
    if (options_.packet_size == 0) {
      arv_camera_gv_set_packet_size_adjustment(camera_, ARV_GV_PACKET_SIZE_ADJUSTMENT_ALWAYS);
      return;
    }
    arv_camera_gv_set_packet_size_adjustment(camera_, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
    arv_camera_gv_set_packet_size(camera_, options_.packet_size, error_.Receive());
    const std::string place = Option("packet_size", options_.packet_size);
    error_.Check(place);
    Tell(place, AlteredText(options_.packet_size, arv_camera_gv_get_packet_size(camera_, nullptr)));
  }

  ArvCamera* camera_;
  ArvDevice* device_;
  const AravisOptions& options_;
  ArvError error_;
  AravisSetUp set_up_;
};

}  // namespace

AravisSetUp SetUpAravis(ArvCamera* camera, const AravisOptions& options) { return AravisSetter(camera, options).Run(); }

}  // namespace chequer
