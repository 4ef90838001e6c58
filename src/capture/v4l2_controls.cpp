#include "capture/v4l2_controls.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "core/suggestion.h"

namespace chequer {
namespace {

[[noreturn]] void Refuse(const CameraSetting& setting, const std::string& why) {
  throw std::runtime_error(setting.place + ": " + why);
}

bool SameText(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

std::int64_t ResolveMenu(const V4l2Control& control, const CameraSetting& setting) {
  const auto* number = std::get_if<std::int64_t>(&setting.value);
  const auto* text = std::get_if<std::string>(&setting.value);
  for (const auto& [value, name] : control.menu)
    if ((number != nullptr && *number == value) || (text != nullptr && SameText(*text, name))) return value;
  Refuse(setting, "must be " + AllowedText(control));
}

std::int64_t ResolveBoolean(const V4l2Control& control, const CameraSetting& setting) {
  if (const auto* value = std::get_if<bool>(&setting.value)) return *value ? 1 : 0;
  const auto* number = std::get_if<std::int64_t>(&setting.value);
  if (number == nullptr || *number < 0 || *number > 1) Refuse(setting, "must be " + AllowedText(control));
  return *number;
}

std::int64_t ResolveInteger(const V4l2Control& control, const CameraSetting& setting) {
  const auto* number = std::get_if<std::int64_t>(&setting.value);
  if (number == nullptr || *number < control.min || *number > control.max)
    Refuse(setting, "must be " + AllowedText(control));
  return *number;
}

std::string ResolveText(const V4l2Control& control, const CameraSetting& setting) {
  const auto* text = std::get_if<std::string>(&setting.value);
  const auto length = static_cast<std::int64_t>(text == nullptr ? 0 : text->size());
  if (text == nullptr || length < control.min || length > control.max)
    Refuse(setting, "must be " + AllowedText(control));
  return *text;
}

}  // namespace

std::string ControlName(std::string_view name_of_driver) {
  std::string name;
  for (const char c : name_of_driver) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (name.ends_with('_')) name.pop_back();
  return name;
}

std::string AllowedText(const V4l2Control& control) {
  switch (control.kind) {
    case V4l2ControlKind::kBoolean: return "true or false";
    case V4l2ControlKind::kButton: return "true, which presses it";
    case V4l2ControlKind::kString:
      return "a text of " + std::to_string(control.min) + " to " + std::to_string(control.max) + " characters";
    case V4l2ControlKind::kMenu: {
      std::string text;
      for (std::size_t i = 0; i < control.menu.size(); ++i)
        text += (i == 0                         ? ""
                 : i + 1 == control.menu.size() ? " or "
                                                : ", ") +
                std::to_string(control.menu[i].first) + " (" + control.menu[i].second + ")";
      return text;
    }
    default: break;
  }
  const std::string range = "from " + std::to_string(control.min) + " to " + std::to_string(control.max);
  return control.step > 1 ? range + ", step " + std::to_string(control.step) : range;
}

std::string ControlValueText(const V4l2Control& control, const V4l2ControlValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  const std::int64_t number = std::get<std::int64_t>(value);
  if (control.kind == V4l2ControlKind::kBoolean) return number != 0 ? "true" : "false";
  for (const auto& [item, name] : control.menu)
    if (item == number) return std::to_string(number) + " (" + name + ")";
  return std::to_string(number);
}

const V4l2Control& FindControl(const std::vector<V4l2Control>& controls, const CameraSetting& setting) {
  std::string known;
  std::vector<std::string> names;
  for (const V4l2Control& control : controls) {
    if (control.name == setting.name) return control;
    known += (known.empty() ? "" : ", ") + control.name;
    names.push_back(control.name);
  }
  Refuse(setting, "the camera has no such control; it has " + (known.empty() ? std::string("none") : known) +
                      DidYouMean(setting.name, names) + " (chequer cameras tells their ranges)");
}

V4l2ControlValue ResolveControl(const V4l2Control& control, const CameraSetting& setting) {
  if (control.is_read_only) Refuse(setting, "this control can only be read");
  switch (control.kind) {
    case V4l2ControlKind::kMenu: return ResolveMenu(control, setting);
    case V4l2ControlKind::kBoolean:
    case V4l2ControlKind::kButton: return ResolveBoolean(control, setting);
    case V4l2ControlKind::kInteger:
    case V4l2ControlKind::kBitmask: return ResolveInteger(control, setting);
    case V4l2ControlKind::kString: return ResolveText(control, setting);
    case V4l2ControlKind::kOther: break;
  }
  Refuse(setting, "this control holds neither a number nor a text and cannot be set from here");
}

std::vector<CameraSetting> InOrderOfSetting(const std::vector<V4l2Control>& controls,
                                            std::vector<CameraSetting> settings) {
  std::stable_partition(settings.begin(), settings.end(), [&](const CameraSetting& setting) {
    const V4l2ControlKind kind = FindControl(controls, setting).kind;
    return kind == V4l2ControlKind::kMenu || kind == V4l2ControlKind::kBoolean;
  });
  return settings;
}

}  // namespace chequer
