#pragma once

#include "capture/camera_options.h"
#include "core/toml_reader.h"

namespace chequer {

// Keys of [capture] for cameras; config/chequerd.toml says what each means. All throw std::runtime_error naming file,
// line, key, value and what would be right.

/// Both kinds: device, pixel_format, width, height, fps, buffers, gamma.
/// @param settings the table of what the driver calls its own: controls or features.
CameraOptions ReadCameraOptions(TomlTable& table, const char* settings);

/// source = "v4l2": these, yuv_range, input and [capture.controls].
V4l2Options ReadV4l2Options(TomlTable& table);

/// source = "aravis": these, offset_x, offset_y, binning_x, binning_y, exposure_us, exposure_auto, gain, gain_auto,
/// white_balance_auto, balance_red, balance_blue, trigger, trigger_line, packet_size, packet_resend, ptp and
/// [capture.features].
AravisOptions ReadAravisOptions(TomlTable& table);

}  // namespace chequer
