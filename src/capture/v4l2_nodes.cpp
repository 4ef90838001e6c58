#include "capture/v4l2_nodes.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace chequer {
namespace {

namespace fs = std::filesystem;

/// The first line of a small file of sysfs; empty where it cannot be read.
std::string FirstLine(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

/// The number in "video12"; nothing for other names.
std::optional<int> NodeNumber(std::string_view name) {
  if (!name.starts_with("video")) return std::nullopt;
  name.remove_prefix(5);
  int number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc() || end != name.data() + name.size()) return std::nullopt;
  return number;
}

/// The serial number of the USB device that an interface in sysfs belongs to.
std::string UsbSerial(fs::path device, const fs::path& sysfs) {
  for (; device.native().size() > sysfs.native().size(); device = device.parent_path()) {
    std::error_code error;
    if (fs::exists(device / "idVendor", error)) return FirstLine(device / "serial");
  }
  return {};
}

std::vector<std::string> LinksTo(const fs::path& node, const fs::path& dev) {
  std::vector<std::string> links;
  for (const char* folder : {"v4l/by-id", "v4l/by-path"}) {
    std::error_code error;
    for (fs::directory_iterator link(dev / folder, error), end; !error && link != end; link.increment(error)) {
      std::error_code broken;
      if (fs::canonical(link->path(), broken) == node && !broken) links.push_back(link->path().string());
    }
  }
  std::sort(links.begin(), links.end());
  return links;
}

V4l2Node ReadNode(const fs::path& entry, const V4l2Roots& roots) {
  V4l2Node node;
  node.path = (roots.dev / entry.filename()).string();
  node.name = FirstLine(entry / "name");
  const std::string index = FirstLine(entry / "index");
  std::from_chars(index.data(), index.data() + index.size(), node.index);
  std::error_code error;
  const fs::path sysfs = fs::canonical(roots.sysfs, error);
  const fs::path device = fs::canonical(entry / "device", error);
  if (!error) {
    node.port = device.lexically_relative(sysfs).string();
    node.serial = UsbSerial(device, sysfs);
  } else {
    // Devices of software, such as a loop, are nowhere but among their likes: their own entry is all they have.
    std::error_code none;
    node.port = fs::canonical(entry, none).lexically_relative(sysfs).string();
  }
  node.links = LinksTo(roots.dev / entry.filename(), roots.dev);
  return node;
}

std::string Describe(const V4l2Node& node) {
  std::string text = node.path + " (" + node.name;
  if (!node.serial.empty()) text += ", serial " + node.serial;
  return text + ")";
}

std::string ListText(const std::vector<V4l2Node>& nodes) {
  if (nodes.empty()) return "no V4L2 device is there";
  std::string text = "there are ";
  for (std::size_t i = 0; i < nodes.size(); ++i) text += (i == 0 ? "" : ", ") + Describe(nodes[i]);
  return text;
}

bool IsNamedBy(const V4l2Node& node, const std::string& device) {
  return node.path == device || node.name == device || (!node.serial.empty() && node.serial == device) ||
         std::find(node.links.begin(), node.links.end(), device) != node.links.end();
}

/// Whether two nodes are the same camera, plugged in again. Without a serial number it is what is at the same place.
bool IsSameCamera(const V4l2Node& a, const V4l2Node& b) {
  if (a.name != b.name || a.index != b.index || a.serial != b.serial) return false;
  return !a.serial.empty() || a.port == b.port;
}

V4l2Found FindAgain(const std::vector<V4l2Node>& nodes, const V4l2Node& known, const std::string& place) {
  std::vector<V4l2Node> same;
  std::copy_if(nodes.begin(), nodes.end(), std::back_inserter(same),
               [&](const V4l2Node& node) { return IsSameCamera(node, known); });
  // Cameras of one maker sometimes all have the same serial number; then the place decides.
  for (const V4l2Node& node : same)
    if (same.size() == 1 || node.port == known.port) return {node, {}};
  return {{}, place + ": the camera " + Describe(known) + " is not there any more; " + ListText(nodes)};
}

}  // namespace

std::vector<V4l2Node> ListV4l2Nodes(const V4l2Roots& roots) {
  std::vector<std::pair<int, V4l2Node>> numbered;
  std::error_code error;
  for (fs::directory_iterator entry(roots.sysfs / "class/video4linux", error), end; !error && entry != end;
       entry.increment(error))
    if (const auto number = NodeNumber(entry->path().filename().string()))
      numbered.emplace_back(*number, ReadNode(entry->path(), roots));
  std::sort(numbered.begin(), numbered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<V4l2Node> nodes;
  for (auto& [number, node] : numbered) nodes.push_back(std::move(node));
  return nodes;
}

V4l2Found FindV4l2Node(const std::vector<V4l2Node>& nodes, const std::string& device, const std::string& place,
                       const std::optional<V4l2Node>& known) {
  if (known && !device.starts_with(kStableLinks)) return FindAgain(nodes, *known, place);
  std::vector<V4l2Node> meant;
  for (const V4l2Node& node : nodes)
    // Of the nodes of one camera the first carries the pictures, others carry what describes them.
    if (device.empty() ? node.index == 0 : IsNamedBy(node, device)) meant.push_back(node);
  if (!device.empty() && meant.size() > 1)
    std::erase_if(meant, [&](const V4l2Node& node) { return node.index != meant.front().index; });
  if (meant.size() == 1) return {meant.front(), {}};
  if (meant.empty()) {
    const std::string what = device.empty() ? "no camera is there" : "no camera '" + device + "' is there";
    return {{}, place + ": " + what + "; " + ListText(nodes)};
  }
  throw std::runtime_error(place + ": " + (device.empty() ? "is missing, and" : "'" + device + "' is not enough:") +
                           " several cameras are meant: " + ListText(meant).substr(10) +
                           "; name one by its serial number or its link in /dev/v4l/by-path");
}

}  // namespace chequer
