#pragma once

#include <arv.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "capture/camera_trouble.h"

namespace chequer {

struct UnrefObject {
  void operator()(void* object) const { g_object_unref(object); }
};
/// Owns one reference to an object of GLib.
template <typename Object>
using ObjectHandle = std::unique_ptr<Object, UnrefObject>;

struct FreeMemory {
  void operator()(const void* memory) const { g_free(const_cast<void*>(memory)); }
};
/// Owns memory of GLib.
template <typename Value>
using MemoryHandle = std::unique_ptr<Value, FreeMemory>;

/// Receives the error of a call of Aravis.
class ArvError {
 public:
  ArvError() = default;
  ArvError(const ArvError&) = delete;
  ArvError& operator=(const ArvError&) = delete;
  ~ArvError() { g_clear_error(&error_); }

  /// Where a call is to put its error; what was there is forgotten.
  GError** Receive() {
    g_clear_error(&error_);
    return &error_;
  }
  bool is_set() const { return error_ != nullptr; }
  std::string message() const { return error_ == nullptr ? std::string() : error_->message; }
  /// Whether the camera did not answer, or is not ours now, rather than not being able to do what was asked.
  bool may_pass() const;

  /// Throws if there is an error: CameraNotReady where it may pass, else std::runtime_error. `place` stands in front.
  void Check(const std::string& place) const;

 private:
  GError* error_ = nullptr;
};

}  // namespace chequer
