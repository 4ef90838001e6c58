#include "capture/aravis_session.h"

#include <algorithm>
#include <utility>

namespace chequer {
namespace {

struct BufferLease final : FrameLease {
  BufferLease(std::shared_ptr<AravisSession> of, ArvBuffer* kept) : session(std::move(of)), buffer(kept) {}
  ~BufferLease() override { session->GiveBack(buffer); }
  std::shared_ptr<AravisSession> session;  ///< shared: the frame may outlive the source
  ArvBuffer* buffer;
};

std::uint64_t Count(ArvStream* stream, const char* name) {
  for (guint i = 0; i < arv_stream_get_n_infos(stream); ++i)
    if (g_strcmp0(arv_stream_get_info_name(stream, i), name) == 0) return arv_stream_get_info_uint64(stream, i);
  return 0;
}

}  // namespace

std::shared_ptr<AravisSession> AravisSession::Start(ObjectHandle<ArvCamera> camera, int buffers, bool packet_resend) {
  std::shared_ptr<AravisSession> session(new AravisSession(std::move(camera)));
  ArvCamera* opened = session->camera_.get();
  ArvError error;
  session->lost_handler_ = g_signal_connect(arv_camera_get_device(opened), "control-lost",
                                            G_CALLBACK(&AravisSession::OnControlLost), session.get());
  session->stream_.reset(arv_camera_create_stream(opened, &AravisSession::OnStream, session.get(), error.Receive()));
  error.Check("making the stream");
  if (!session->stream_) throw CameraNotReady("the camera gives no stream");
  if (arv_camera_is_gv_device(opened) != 0)
    g_object_set(session->stream_.get(), "packet-resend",
                 packet_resend ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER,
                 "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_AUTO, nullptr);
  const guint payload = arv_camera_get_payload(opened, error.Receive());
  error.Check("asking for the size of a frame");
  if (payload == 0) throw CameraNotReady("the camera says that its frames are empty");
  for (int i = 0; i < buffers; ++i) session->GiveBack(arv_buffer_new_allocate(payload));
  arv_camera_start_acquisition(opened, error.Receive());
  error.Check("starting to stream");
  return session;
}

AravisSession::~AravisSession() { Close(false); }

void AravisSession::OnStream(void* data, ArvStreamCallbackType type, ArvBuffer*) {
  if (type != ARV_STREAM_CALLBACK_TYPE_BUFFER_DONE) return;
  auto* session = static_cast<AravisSession*>(data);
  {
    const std::lock_guard lock(session->mutex_);
    ++session->ready_;
    --session->queued_;
  }
  session->woken_.notify_all();
}

void AravisSession::OnControlLost(ArvDevice*, void* data) {
  auto* session = static_cast<AravisSession*>(data);
  {
    const std::lock_guard lock(session->mutex_);
    session->lost_ = true;
  }
  session->woken_.notify_all();
}

AravisSession::Woken AravisSession::Wait(std::chrono::microseconds time) {
  std::unique_lock lock(mutex_);
  woken_.wait_for(lock, std::max(time, std::chrono::microseconds(0)),
                  [this] { return ready_ > 0 || interrupted_ || lost_; });
  if (std::exchange(interrupted_, false)) return Woken::kByInterrupt;
  if (ready_ > 0) return Woken::kByFrame;
  return lost_ ? Woken::kByLoss : Woken::kByTime;
}

void AravisSession::Interrupt() {
  {
    const std::lock_guard lock(mutex_);
    interrupted_ = true;
  }
  woken_.notify_all();
}

ArvBuffer* AravisSession::Pop() {
  const std::lock_guard lock(mutex_);
  ArvBuffer* buffer = stream_ ? arv_stream_try_pop_buffer(stream_.get()) : nullptr;
  if (buffer != nullptr && ready_ > 0) --ready_;
  if (buffer == nullptr) ready_ = 0;
  return buffer;
}

void AravisSession::GiveBack(ArvBuffer* buffer) {
  const std::lock_guard lock(mutex_);
  if (!stream_) return g_object_unref(buffer);
  arv_stream_push_buffer(stream_.get(), buffer);
  ++queued_;
}

std::unique_ptr<FrameLease> AravisSession::Lend(ArvBuffer* buffer) {
  return std::make_unique<BufferLease>(shared_from_this(), buffer);
}

int AravisSession::queued() const {
  const std::lock_guard lock(mutex_);
  return queued_;
}

std::string AravisSession::Trigger() {
  ArvError error;
  arv_camera_software_trigger(camera_.get(), error.Receive());
  return error.message();
}

std::string AravisSession::Statistics() const {
  const std::uint64_t missing = Count(stream_.get(), "n_missing_packets");
  const std::uint64_t resent = Count(stream_.get(), "n_resent_packets");
  const std::uint64_t underruns = Count(stream_.get(), "n_underruns");
  std::string text;
  const auto add = [&](std::uint64_t count, const char* what) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + what;
  };
  add(missing, " packets missing");
  add(resent, " packets resent");
  add(underruns, " frames without a buffer");
  return text;
}

void AravisSession::Close(bool is_gone) {
  if (!camera_) return;
  // A camera that is gone would be told three times in vain, for three seconds each: this one is left out.
  if (!is_gone) arv_camera_stop_acquisition(camera_.get(), nullptr);
  g_signal_handler_disconnect(arv_camera_get_device(camera_.get()), lost_handler_);
  ObjectHandle<ArvStream> stream;
  {
    const std::lock_guard lock(mutex_);
    stream = std::move(stream_);
  }
  stream.reset();  // joins its thread, which may be about to call OnStream: not under the lock
  camera_.reset();
}

}  // namespace chequer
