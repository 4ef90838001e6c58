#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "chequer/image.h"
#include "chequer/tone_curve.h"

namespace chequer {

/// A control or feature of a camera by the name that its driver gives it.
struct CameraSetting {
  using Value = std::variant<bool, std::int64_t, double, std::string>;
  std::string name;
  Value value;
  std::string place;  ///< for messages: "swarm.toml:12: capture.controls.gain = 300"
};

/// What was written where, for messages about what a camera cannot do: "swarm.toml:5: capture.pixel_format = 'NV12'".
struct CameraOptionPlaces {
  std::string device = "capture.device";
  std::string pixel_format = "capture.pixel_format";
  std::string width = "capture.width";
  std::string fps = "capture.fps";
};

/// What cameras of both kinds have in common.
struct CameraOptions {
  std::string device;                       ///< which one; empty: the only one there is
  std::optional<std::string> pixel_format;  ///< a name of ParsePixelFormat, or MJPEG; else the best there is
  std::optional<int> width;                 ///< pixels; both sides or none
  std::optional<int> height;
  double fps = 30;  ///< frames a second that are asked for
  int buffers = 8;  ///< frames that the driver may fill ahead of us
  ToneCurve tone_curve = ToneCurve::Srgb();
  std::vector<CameraSetting> settings;  ///< in the order in which they are to be set
  CameraOptionPlaces places;
};

/// A camera of Video4Linux.
struct V4l2Options {
  CameraOptions camera;               ///< device: a node (/dev/…, also by-id and by-path), a name or a serial number
  std::optional<YuvRange> yuv_range;  ///< else what the driver says
  std::optional<int> input;           ///< else the one that is chosen
};

/// What makes a camera take a frame.
enum class TriggerKind : std::uint8_t {
  kFree,      ///< its own clock
  kSoftware,  ///< a command from us, `fps` times a second
  kHardware,  ///< a signal on `trigger_line`
};

/// How often a camera adjusts a value by itself.
enum class AutoMode : std::uint8_t { kOff, kOnce, kContinuous };

/// A GenICam camera: GigE Vision or USB3 Vision.
struct AravisOptions {
  CameraOptions camera;         ///< device: id, serial number, "vendor model", model, IP or MAC address
  std::optional<int> offset_x;  ///< of the region on the sensor, pixels
  std::optional<int> offset_y;
  std::optional<int> binning_x;  ///< pixels of the sensor a pixel
  std::optional<int> binning_y;
  std::optional<double> exposure_us;
  std::optional<AutoMode> exposure_auto;
  std::optional<double> gain;  ///< in the camera's unit, mostly dB
  std::optional<AutoMode> gain_auto;
  std::optional<AutoMode> white_balance_auto;
  std::optional<double> balance_red;   ///< BalanceRatio of Red
  std::optional<double> balance_blue;  ///< BalanceRatio of Blue
  TriggerKind trigger = TriggerKind::kFree;
  std::string trigger_line = "Line0";  ///< of kHardware: TriggerSource
  int packet_size = 0;                 ///< bytes; 0: the largest that gets through
  bool packet_resend = true;           ///< ask for packets that were lost
  bool ptp = false;                    ///< let the camera's clock follow the network's (IEEE 1588)
};

}  // namespace chequer
