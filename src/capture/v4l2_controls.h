#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "capture/camera_options.h"

namespace chequer {

enum class V4l2ControlKind : std::uint8_t { kInteger, kBoolean, kMenu, kButton, kBitmask, kString, kOther };

/// A control of a V4L2 driver.
struct V4l2Control {
  std::uint32_t id = 0;
  std::string name;  ///< as ControlName makes it
  V4l2ControlKind kind = V4l2ControlKind::kOther;
  std::int64_t min = 0, max = 0, step = 1, default_value = 0;
  bool is_wide = false;  ///< 64 bits
  bool is_read_only = false;
  bool is_inactive = false;                                ///< another control, mostly its automatic, governs it now
  std::vector<std::pair<std::int64_t, std::string>> menu;  ///< of kMenu: value and what it means
};

/// What a control is set to.
using V4l2ControlValue = std::variant<std::int64_t, std::string>;

/// The name as v4l2-ctl writes it: "White Balance Temperature, Auto" is white_balance_temperature_auto.
std::string ControlName(std::string_view name_of_driver);

/// What a control allows, such as "from 0 to 255, step 5", "true or false", "0 (Disabled), 1 (50 Hz) or 2 (60 Hz)".
std::string AllowedText(const V4l2Control& control);

/// A value as AllowedText would name it: "2 (60 Hz)".
std::string ControlValueText(const V4l2Control& control, const V4l2ControlValue& value);

/// The control that a setting means. Throws std::runtime_error naming the setting's place and the controls that exist.
const V4l2Control& FindControl(const std::vector<V4l2Control>& controls, const CameraSetting& setting);

/// The value that a setting means: numbers, true and false, or the text of a menu's line. Throws std::runtime_error
/// naming the setting's place and what would be right; also where the control is read only.
V4l2ControlValue ResolveControl(const V4l2Control& control, const CameraSetting& setting);

/// The settings in the order in which they must be set: what switches an automatic off comes before what it governs.
std::vector<CameraSetting> InOrderOfSetting(const std::vector<V4l2Control>& controls,
                                            std::vector<CameraSetting> settings);

}  // namespace chequer
