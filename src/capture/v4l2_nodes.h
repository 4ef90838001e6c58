#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace chequer {

/// A device node of V4L2 and what tells it from others.
struct V4l2Node {
  std::string path;    ///< /dev/video0
  std::string name;    ///< as the driver calls the camera
  std::string serial;  ///< of the USB device; empty where it has none
  std::string port;    ///< where it is plugged in: the device's path in sysfs; the same after plugging in again
  int index = 0;       ///< which of the nodes of the same device it is
  std::vector<std::string> links;  ///< under /dev/v4l/by-id and by-path

  bool operator==(const V4l2Node&) const = default;
};

/// Where to look; tests have folders of their own.
struct V4l2Roots {
  std::filesystem::path sysfs = "/sys";
  std::filesystem::path dev = "/dev";
};

/// All nodes, by number. Empty where the kernel has no V4L2.
std::vector<V4l2Node> ListV4l2Nodes(const V4l2Roots& roots = {});

/// Where links are that udev makes anew when a camera is plugged in again.
inline constexpr const char* kStableLinks = "/dev/v4l/";

/// Which node is meant, or why none is. Throws std::runtime_error where several could be meant, which no waiting
/// repairs. For messages `place` stands in front.
///
/// @param device a path (a node or a link to one), a camera's name, or its serial number; empty: the only camera.
/// @param known the camera that was found before, if one was: the same one is found again, also under another node,
///   and no other is taken for it. Not used where `device` is one of kStableLinks, which says it all.
struct V4l2Found {
  std::optional<V4l2Node> node;
  std::string problem;  ///< empty if there is a node
};
V4l2Found FindV4l2Node(const std::vector<V4l2Node>& nodes, const std::string& device, const std::string& place,
                       const std::optional<V4l2Node>& known);

}  // namespace chequer
