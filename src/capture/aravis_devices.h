#pragma once

#include <optional>
#include <string>
#include <vector>

namespace chequer {

/// A GenICam camera that answers.
struct AravisDevice {
  std::string id;  ///< Aravis's name: "vendor-model-serial"
  std::string vendor;
  std::string model;
  std::string serial;
  std::string address;   ///< IP address, or the USB device's GUID
  std::string hardware;  ///< MAC address, or the USB device's GUID
  std::string protocol;  ///< "GigEVision", "USB3Vision", "Fake"

  bool operator==(const AravisDevice&) const = default;
};

/// All cameras that answer within a second. One thread at a time.
std::vector<AravisDevice> ListAravisDevices();

/// Which camera is meant, or why none is. Throws std::runtime_error where several could be meant, which no waiting
/// repairs. For messages `place` stands in front.
///
/// @param device an id, a serial number, "vendor model", a model, an IP or a MAC address; empty: the only camera.
/// @param known the camera that was found before, if one was: the same one is found again, whatever address it has.
struct AravisFound {
  std::optional<AravisDevice> device;
  std::string problem;  ///< empty if there is one
};
AravisFound FindAravisDevice(const std::vector<AravisDevice>& devices, const std::string& device,
                             const std::string& place, const std::optional<AravisDevice>& known);

/// Whether a text is an address of IPv4, which can be asked for though nobody answers to it in the own network.
bool IsIpAddress(const std::string& text);

}  // namespace chequer
