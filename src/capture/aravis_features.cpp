#include "capture/aravis_features.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/number_text.h"

namespace chequer {
namespace {

/// The names that a call gives. @param call puts their number where it is told, and returns a list that we own.
template <typename Call>
std::vector<std::string> Names(const Call& call) {
  guint count = 0;
  const MemoryHandle<const char*> names(call(&count));
  std::vector<std::string> texts;
  for (guint i = 0; names && i < count; ++i) texts.emplace_back(names.get()[i]);
  return texts;
}

/// One feature that is set, and what is wrong with its value if need be.
struct Feature {
  ArvDevice* device;
  ArvGcNode* node;
  const CameraSetting& setting;
  std::string allowed;

  const char* name() const { return setting.name.c_str(); }
  [[noreturn]] void Refuse() const {
    throw std::runtime_error(setting.place + ": " + (allowed.empty() ? "cannot be that" : "must be " + allowed));
  }
};

void SetTruth(const Feature& feature, ArvError& error) {
  const auto* value = std::get_if<bool>(&feature.setting.value);
  if (value == nullptr) feature.Refuse();
  arv_device_set_boolean_feature_value(feature.device, feature.name(), *value ? 1 : 0, error.Receive());
}

void SetText(const Feature& feature, ArvError& error) {
  const auto* value = std::get_if<std::string>(&feature.setting.value);
  const auto is_entry = [&] {
    return arv_device_is_enumeration_entry_available(feature.device, feature.name(), value->c_str(), nullptr) != 0;
  };
  if (value == nullptr || (ARV_IS_GC_ENUMERATION(feature.node) != 0 && !is_entry())) feature.Refuse();
  arv_device_set_string_feature_value(feature.device, feature.name(), value->c_str(), error.Receive());
}

std::string SetDecimal(const Feature& feature, double value, ArvError& error) {
  double min = 0, max = 0;
  arv_device_get_float_feature_bounds(feature.device, feature.name(), &min, &max, error.Receive());
  if (!error.is_set() && (value < min || value > max)) feature.Refuse();
  arv_device_set_float_feature_value(feature.device, feature.name(), value, error.Receive());
  if (error.is_set()) return {};
  return AlteredText(value, arv_device_get_float_feature_value(feature.device, feature.name(), nullptr));
}

std::string SetWhole(const Feature& feature, std::int64_t value, ArvError& error) {
  gint64 min = 0, max = 0;
  arv_device_get_integer_feature_bounds(feature.device, feature.name(), &min, &max, error.Receive());
  if (!error.is_set() && (value < min || value > max)) feature.Refuse();
  arv_device_set_integer_feature_value(feature.device, feature.name(), value, error.Receive());
  if (error.is_set() || ARV_IS_GC_INTEGER(feature.node) == 0) return {};
  const gint64 got = arv_device_get_integer_feature_value(feature.device, feature.name(), nullptr);
  return AlteredText(static_cast<double>(value), static_cast<double>(got));
}

std::string SetNumber(const Feature& feature, ArvError& error) {
  const auto* whole = std::get_if<std::int64_t>(&feature.setting.value);
  const auto* decimal = std::get_if<double>(&feature.setting.value);
  if (whole == nullptr && (decimal == nullptr || ARV_IS_GC_FLOAT(feature.node) == 0)) feature.Refuse();
  if (ARV_IS_GC_FLOAT(feature.node) == 0) return SetWhole(feature, *whole, error);
  return SetDecimal(feature, whole != nullptr ? static_cast<double>(*whole) : *decimal, error);
}

}  // namespace

std::string JoinedWithOr(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

std::string AlteredText(double wanted, double got) {
  const bool is_other = std::abs(got - wanted) > 0.01 * std::max(std::abs(wanted), 1e-9);
  return is_other ? "the camera made it " + RoundText(got) : "";
}

std::vector<std::string> GenicamFormats(ArvCamera* camera) {
  ArvError error;
  const std::vector<std::string> formats = Names(
      [&](guint* count) { return arv_camera_dup_available_pixel_formats_as_strings(camera, count, error.Receive()); });
  error.Check("reading the pixel formats");
  return formats;
}

std::vector<std::string> TriggerSources(ArvCamera* camera, ArvError& error) {
  return Names([&](guint* count) { return arv_camera_dup_available_trigger_sources(camera, count, error.Receive()); });
}

std::string AllowedByFeature(ArvDevice* device, const char* feature) {
  ArvGcNode* node = arv_device_get_feature(device, feature);
  ArvError error;
  if (node == nullptr) return {};
  if (ARV_IS_GC_BOOLEAN(node) != 0) return "true or false";
  if (ARV_IS_GC_COMMAND(node) != 0) return "true, which runs it";
  if (ARV_IS_GC_ENUMERATION(node) != 0) {
    return JoinedWithOr(Names([&](guint* count) {
      return arv_device_dup_available_enumeration_feature_values_as_strings(device, feature, count, error.Receive());
    }));
  }
  if (ARV_IS_GC_FLOAT(node) != 0) {
    double min = 0, max = 0;
    arv_device_get_float_feature_bounds(device, feature, &min, &max, error.Receive());
    return error.is_set() ? "" : "a number from " + RoundText(min) + " to " + RoundText(max);
  }
  if (ARV_IS_GC_INTEGER(node) != 0) {
    gint64 min = 0, max = 0;
    arv_device_get_integer_feature_bounds(device, feature, &min, &max, error.Receive());
    return error.is_set() ? "" : "a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  }
  return ARV_IS_GC_STRING(node) != 0 ? "a text" : "";
}

std::string SetFeature(ArvDevice* device, const CameraSetting& setting) {
  const char* name = setting.name.c_str();
  ArvGcNode* node = arv_device_get_feature(device, name);
  if (node == nullptr || ARV_IS_GC_CATEGORY(node) != 0)
    throw std::runtime_error(setting.place +
                             ": the camera has no such feature (chequer cameras --features lists them)");
  if (arv_device_is_feature_available(device, name, nullptr) == 0)
    throw std::runtime_error(setting.place + ": this feature is not available as the camera is set now");
  const Feature feature{device, node, setting, AllowedByFeature(device, name)};
  ArvError error;
  std::string altered;
  if (ARV_IS_GC_COMMAND(node) != 0)
    arv_device_execute_command(device, name, error.Receive());
  else if (ARV_IS_GC_BOOLEAN(node) != 0)
    SetTruth(feature, error);
  else if (ARV_IS_GC_ENUMERATION(node) != 0 || ARV_IS_GC_STRING(node) != 0)
    SetText(feature, error);
  else
    altered = SetNumber(feature, error);
  error.Check(setting.place + (feature.allowed.empty() ? "" : " (allowed is " + feature.allowed + ")"));
  return altered;
}

}  // namespace chequer
