#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "capture/aravis_handles.h"
#include "chequer/frame.h"

namespace chequer {

/// A camera that streams, and its buffers. Shared by the source, the frames that look into its buffers, and whoever
/// takes it apart. Any thread, but for what is said below.
class AravisSession : public std::enable_shared_from_this<AravisSession> {
 public:
  /// Takes over a camera that is set up, and starts it. Throws CameraNotReady, or std::runtime_error where it cannot
  /// stream.
  static std::shared_ptr<AravisSession> Start(ObjectHandle<ArvCamera> camera, int buffers, bool packet_resend);
  ~AravisSession();
  AravisSession(const AravisSession&) = delete;
  AravisSession& operator=(const AravisSession&) = delete;

  enum class Woken { kByFrame, kByTime, kByInterrupt, kByLoss };
  /// Waits until a buffer is filled, the time is up, someone interrupts, or control of the camera is lost.
  Woken Wait(std::chrono::microseconds time);
  void Interrupt();

  /// A filled buffer; null if there is none. Must be given back, or lent.
  ArvBuffer* Pop();
  void GiveBack(ArvBuffer* buffer);
  /// Keeps a buffer for a frame and gives it back when the frame dies.
  std::unique_ptr<FrameLease> Lend(ArvBuffer* buffer);
  /// Buffers that the camera's frames can go into now.
  int queued() const;

  /// Makes the camera take a frame; empty, or what is wrong. The source's thread alone.
  std::string Trigger();
  ArvCamera* camera() const { return camera_.get(); }

  /// "3 packets missing, 2 resent"; empty where there is nothing to tell. The source's thread alone.
  std::string Statistics() const;

  /// Stops and lets go of the camera. Of one that is gone it takes seconds until every attempt to tell it so is given
  /// up. Buffers that frames still look into stay.
  void Close(bool is_gone);

 private:
  explicit AravisSession(ObjectHandle<ArvCamera> camera) : camera_(std::move(camera)) {}
  static void OnStream(void* session, ArvStreamCallbackType type, ArvBuffer* buffer);
  static void OnControlLost(ArvDevice* device, void* session);

  ObjectHandle<ArvCamera> camera_;
  gulong lost_handler_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable woken_;
  ObjectHandle<ArvStream> stream_;  ///< null once closed
  std::uint64_t ready_ = 0;         ///< filled buffers that were not fetched
  int queued_ = 0;
  bool interrupted_ = false;
  bool lost_ = false;
};

}  // namespace chequer
