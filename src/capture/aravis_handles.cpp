#include "capture/aravis_handles.h"

namespace chequer {

bool ArvError::may_pass() const {
  if (error_ == nullptr || error_->domain != ARV_DEVICE_ERROR) return false;
  switch (error_->code) {
    case ARV_DEVICE_ERROR_NOT_CONNECTED:
    case ARV_DEVICE_ERROR_PROTOCOL_ERROR:
    case ARV_DEVICE_ERROR_TRANSFER_ERROR:
    case ARV_DEVICE_ERROR_TIMEOUT:
    case ARV_DEVICE_ERROR_NOT_FOUND:
    case ARV_DEVICE_ERROR_NOT_CONTROLLER:
    case ARV_DEVICE_ERROR_PROTOCOL_ERROR_ACCESS_DENIED:
    case ARV_DEVICE_ERROR_PROTOCOL_ERROR_BUSY: return true;
    default: return false;
  }
}

void ArvError::Check(const std::string& place) const {
  if (error_ == nullptr) return;
  const std::string message = place + ": " + error_->message;
  if (may_pass()) throw CameraNotReady(message);
  throw std::runtime_error(message);
}

}  // namespace chequer
