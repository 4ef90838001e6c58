#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "capture/camera_options.h"
#include "capture/v4l2_device.h"
#include "chequer/image.h"

namespace chequer {

/// The size and layout that a camera's frames have.
struct V4l2Layout {
  FourCc code = 0;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride_bytes = 0;
  YuvRange range = YuvRange::kFull;
};

/// What a camera was set to.
struct V4l2SetUp {
  V4l2Layout layout;
  double rate_hz = 0;                ///< frames a second
  std::vector<std::string> remarks;  ///< what is not quite as asked, a sentence each
};

/// Sets a camera to the options: input, format, rate and controls, and reads back. Throws CameraNotReady where waiting
/// may help, and std::runtime_error naming what was asked, what exists and what to type where it cannot do it.
/// @param node its path, for messages.
V4l2SetUp SetUpV4l2(const V4l2Device& device, const std::string& node, const V4l2Options& options);

}  // namespace chequer
