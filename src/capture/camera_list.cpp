#include "capture/camera_list.h"

#include <stdexcept>
#include <utility>

#include "capture/v4l2_device.h"
#include "capture/v4l2_nodes.h"

namespace chequer {
namespace {

ListedSize MakeListed(const V4l2SizeOffer& offer) {
  const std::string smallest = std::to_string(offer.min_width) + "x" + std::to_string(offer.min_height);
  const std::string largest = std::to_string(offer.max_width) + "x" + std::to_string(offer.max_height);
  return {smallest == largest ? smallest : smallest + " to " + largest, offer.rates_hz};
}

ListedFormat MakeListed(const V4l2FormatOffer& offer) {
  ListedFormat format{NameOfFourCc(offer.code), FourCcText(offer.code) + " (" + offer.description + ")", {}};
  for (const V4l2SizeOffer& size : offer.sizes) format.sizes.push_back(MakeListed(size));
  return format;
}

ListedControl MakeListed(const V4l2Device& device, const V4l2Control& control) {
  ListedControl listed;
  listed.name = control.name;
  if (!control.is_read_only && control.kind != V4l2ControlKind::kOther) listed.allowed = AllowedText(control);
  if (const auto value = GetControl(device, control)) listed.value = ControlValueText(control, *value);
  const bool has_default = control.kind != V4l2ControlKind::kString && control.kind != V4l2ControlKind::kButton &&
                           control.kind != V4l2ControlKind::kOther;
  if (has_default) listed.initial = ControlValueText(control, control.default_value);
  listed.is_inactive = control.is_inactive;
  return listed;
}

/// Nothing for the nodes of a camera that carry no pictures.
std::optional<ListedCamera> MakeListed(const V4l2Node& node) {
  ListedCamera camera;
  camera.source = "v4l2";
  camera.device = node.links.empty() ? node.path : node.links.front();
  camera.name = node.name;
  camera.serial = node.serial;
  if (!node.links.empty()) camera.also = {node.links.begin() + 1, node.links.end()};
  if (camera.device != node.path) camera.also.push_back(node.path);
  try {
    const V4l2Device device(node.path);
    if (!QueryCapability(device).captures) return std::nullopt;
    for (const V4l2FormatOffer& offer : QueryFormats(device)) camera.formats.push_back(MakeListed(offer));
    for (const V4l2Control& control : QueryControls(device)) camera.controls.push_back(MakeListed(device, control));
  } catch (const std::runtime_error& error) {
    camera.problem = error.what();
  }
  return camera;
}

}  // namespace

std::vector<ListedCamera> ListV4l2Cameras() {
  std::vector<ListedCamera> cameras;
  for (const V4l2Node& node : ListV4l2Nodes())
    if (auto camera = MakeListed(node)) cameras.push_back(std::move(*camera));
  return cameras;
}

std::vector<ListedCamera> ListCameras(bool all_features) {
  std::vector<ListedCamera> cameras = ListV4l2Cameras();
  for (ListedCamera& camera : ListAravisCameras(all_features)) cameras.push_back(std::move(camera));
  return cameras;
}

}  // namespace chequer
