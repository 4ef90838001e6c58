#include "capture/aravis_devices.h"

#include <arpa/inet.h>
#include <arv.h>

#include <algorithm>
#include <stdexcept>

namespace chequer {
namespace {

std::string Text(const char* text) { return text == nullptr ? std::string() : text; }

std::string Describe(const AravisDevice& device) {
  std::string text = device.id + " (" + device.protocol;
  if (!device.serial.empty()) text += ", serial " + device.serial;
  if (!device.address.empty()) text += ", at " + device.address;
  return text + ")";
}

std::string ListText(const std::vector<AravisDevice>& devices) {
  std::string text;
  for (const AravisDevice& device : devices) text += (text.empty() ? "" : ", ") + Describe(device);
  return text;
}

bool IsNamedBy(const AravisDevice& device, const std::string& name) {
  return name == device.id || name == device.serial || name == device.address || name == device.hardware ||
         name == device.model || name == device.vendor + " " + device.model;
}

}  // namespace

std::vector<AravisDevice> ListAravisDevices() {
  arv_update_device_list();
  std::vector<AravisDevice> devices;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    AravisDevice device;
    device.id = Text(arv_get_device_id(i));
    device.vendor = Text(arv_get_device_vendor(i));
    device.model = Text(arv_get_device_model(i));
    device.serial = Text(arv_get_device_serial_nbr(i));
    device.address = Text(arv_get_device_address(i));
    device.hardware = Text(arv_get_device_physical_id(i));
    device.protocol = Text(arv_get_device_protocol(i));
    devices.push_back(std::move(device));
  }
  return devices;
}

AravisFound FindAravisDevice(const std::vector<AravisDevice>& devices, const std::string& device,
                             const std::string& place, const std::optional<AravisDevice>& known) {
  std::vector<AravisDevice> meant;
  for (const AravisDevice& candidate : devices) {
    const bool is_meant = known            ? candidate.id == known->id && candidate.serial == known->serial
                          : device.empty() ? true
                                           : IsNamedBy(candidate, device);
    if (is_meant) meant.push_back(candidate);
  }
  if (meant.size() == 1) return {meant.front(), {}};
  if (meant.empty()) {
    const std::string what = known            ? "the camera " + Describe(*known) + " does not answer any more"
                             : device.empty() ? "no GenICam camera answers"
                                              : "no camera '" + device + "' answers";
    return {{}, place + ": " + what + (devices.empty() ? "" : "; there are " + ListText(devices))};
  }
  throw std::runtime_error(place + ": " + (device.empty() ? "is missing, and" : "'" + device + "' is not enough:") +
                           " several cameras are meant: " + ListText(meant) +
                           "; name one by its id, serial number or address");
}

bool IsIpAddress(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

}  // namespace chequer
