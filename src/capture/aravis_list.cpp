#include <arv.h>

#include <array>
#include <stdexcept>
#include <utility>

#include "capture/aravis_devices.h"
#include "capture/aravis_features.h"
#include "capture/aravis_formats.h"
#include "capture/aravis_handles.h"
#include "capture/camera_list.h"

namespace chequer {
namespace {

/// What one looks for first; of each camera those that it has.
constexpr std::array<const char*, 24> kUsual{
    "ExposureAuto", "ExposureTime",    "ExposureTimeAbs", "GainAuto",          "Gain",
    "GainRaw",      "BlackLevel",      "Gamma",           "BalanceWhiteAuto",  "BalanceRatioSelector",
    "BalanceRatio", "BalanceRatioAbs", "TriggerMode",     "TriggerSource",     "TriggerActivation",
    "OffsetX",      "OffsetY",         "BinningVertical", "BinningHorizontal", "ReverseX",
    "ReverseY",     "PtpEnable",       "PtpStatus",       "DeviceTemperature"};

ListedControl MakeListed(ArvDevice* device, const std::string& name) {
  ListedControl control;
  control.name = name;
  ArvGcNode* node = arv_device_get_feature(device, name.c_str());
  auto* feature = ARV_GC_FEATURE_NODE(node);
  if (arv_gc_feature_node_get_actual_access_mode(feature) != ARV_GC_ACCESS_MODE_RO)
    control.allowed = AllowedByFeature(device, name.c_str());
  control.is_inactive = arv_gc_feature_node_is_locked(feature, nullptr) != 0;
  ArvError error;
  if (ARV_IS_GC_COMMAND(node) == 0)
    if (const char* value = arv_gc_feature_node_get_value_as_string(feature, error.Receive()); value != nullptr)
      control.value = value;
  return control;
}

/// The names of all features below a category, in the camera's order.
void CollectFeatures(ArvDevice* device, const char* category, int depth, std::vector<std::string>& names) {
  ArvGcNode* node = arv_device_get_feature(device, category);
  constexpr int kDeepest = 16;  // a category may hold itself
  if (ARV_IS_GC_CATEGORY(node) == 0 || depth > kDeepest) return;
  for (const GSList* item = arv_gc_category_get_features(ARV_GC_CATEGORY(node)); item != nullptr; item = item->next) {
    const auto* name = static_cast<const char*>(item->data);
    ArvGcNode* child = arv_device_get_feature(device, name);
    if (ARV_IS_GC_CATEGORY(child) != 0)
      CollectFeatures(device, name, depth + 1, names);
    else if (ARV_IS_GC_FEATURE_NODE(child) != 0)
      names.emplace_back(name);
  }
}

std::string Bounds(gint min_width, gint max_width, gint min_height, gint max_height) {
  return std::to_string(min_width) + "x" + std::to_string(min_height) + " to " + std::to_string(max_width) + "x" +
         std::to_string(max_height);
}

void LookInside(ArvCamera* camera, bool all_features, ListedCamera& listed) {
  ArvDevice* device = arv_camera_get_device(camera);
  gint min_width = 0, max_width = 0, min_height = 0, max_height = 0;
  double slowest = 0, fastest = 0;
  arv_camera_get_width_bounds(camera, &min_width, &max_width, nullptr);
  arv_camera_get_height_bounds(camera, &min_height, &max_height, nullptr);
  ListedSize size{Bounds(min_width, max_width, min_height, max_height), {}};
  ArvError error;
  arv_camera_get_frame_rate_bounds(camera, &slowest, &fastest, error.Receive());
  if (!error.is_set()) size.rates_hz = {fastest, slowest};
  for (const std::string& native : GenicamFormats(camera)) {
    const auto format = PixelFormatOfGenicam(native);
    listed.formats.push_back({format ? std::string(PixelFormatName(*format)) : std::string(), native, {size}});
  }
  std::vector<std::string> names;
  if (all_features)
    CollectFeatures(device, "Root", 0, names);
  else
    names.assign(kUsual.begin(), kUsual.end());
  for (const std::string& name : names)
    if (arv_device_is_feature_available(device, name.c_str(), nullptr) != 0)
      listed.controls.push_back(MakeListed(device, name));
}

}  // namespace

std::vector<ListedCamera> ListAravisCameras(bool all_features) {
  std::vector<ListedCamera> cameras;
  for (const AravisDevice& device : ListAravisDevices()) {
    ListedCamera listed;
    listed.source = "aravis";
    listed.device = device.id;
    listed.name = device.vendor + " " + device.model;
    listed.serial = device.serial;
    for (const std::string& name : {device.address, device.hardware})
      if (!name.empty()) listed.also.push_back(name);
    try {
      ArvError error;
      const ObjectHandle<ArvCamera> camera(arv_camera_new(device.id.c_str(), error.Receive()));
      if (!camera) throw std::runtime_error(error.message());
      LookInside(camera.get(), all_features, listed);
    } catch (const std::runtime_error& error) {
      listed.problem = error.what();
    }
    cameras.push_back(std::move(listed));
  }
  return cameras;
}

}  // namespace chequer
