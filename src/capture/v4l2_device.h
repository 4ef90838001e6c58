#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "capture/v4l2_controls.h"
#include "capture/v4l2_formats.h"

namespace chequer {

/// An open device of V4L2, through libv4l2 with its conversions off. Move-only. Its calls may come from several
/// threads.
class V4l2Device {
 public:
  V4l2Device() = default;
  /// Throws CameraNotReady where waiting may help (it is gone, or not there yet), std::system_error with EACCES where
  /// it may not be opened, and std::runtime_error where the path is no camera.
  explicit V4l2Device(const std::string& path);
  V4l2Device(V4l2Device&& other) noexcept;
  V4l2Device& operator=(V4l2Device&& other) noexcept;
  ~V4l2Device();

  int fd() const { return fd_; }
  bool is_open() const { return fd_ >= 0; }
  /// An ioctl, repeated where a signal interrupts it; 0, or the error number.
  int Control(unsigned long request, void* argument) const;

 private:
  int fd_ = -1;
};

/// What the driver says of itself.
struct V4l2Capability {
  std::string driver;
  std::string card;  ///< name of the camera
  std::string bus;
  bool captures = false;  ///< it gives frames, and streams them
};
V4l2Capability QueryCapability(const V4l2Device& device);

/// The driver's own formats, with sizes and rates.
std::vector<V4l2FormatOffer> QueryFormats(const V4l2Device& device);

/// All controls but those that are disabled.
std::vector<V4l2Control> QueryControls(const V4l2Device& device);

/// Sets a control; 0, or the error number.
int SetControl(const V4l2Device& device, const V4l2Control& control, const V4l2ControlValue& value);

/// The value of a control; nothing where it cannot be read.
std::optional<V4l2ControlValue> GetControl(const V4l2Device& device, const V4l2Control& control);

}  // namespace chequer
