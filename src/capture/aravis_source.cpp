#include "capture/aravis_source.h"

#include <arv.h>
#include <pthread.h>
#include <sys/timex.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "capture/aravis_formats.h"
#include "capture/aravis_handles.h"
#include "capture/aravis_session.h"
#include "capture/aravis_settings.h"
#include "capture/camera_trouble.h"
#include "capture/size_text.h"
#include "core/number_text.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// A camera that follows PTP is as good as the host's own clock, which may be off by milliseconds.
constexpr milliseconds kPtpTolerance{20};
/// How long a camera that answers needs at most to be let go of.
constexpr milliseconds kPatience{1000};
constexpr int kTaiMinusUtc = 37;  // since 2017, where the kernel was not told

std::chrono::seconds TaiMinusUtc() {
  timex state{};
  adjtimex(&state);
  return std::chrono::seconds(state.tai != 0 ? state.tai : kTaiMinusUtc);
}

const char* WhyIncomplete(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_TIMEOUT: return "packets of it did not come in time";
    case ARV_BUFFER_STATUS_MISSING_PACKETS: return "packets of it are missing";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID: return "a packet of it has a wrong number";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH: return "it is larger than the camera said";
    case ARV_BUFFER_STATUS_ABORTED: return "it was broken off";
    default: return "it is not complete";
  }
}

/// Looks into a filled buffer; empty, or why it cannot be used.
std::string Look(ArvBuffer* buffer, const ToneCurve& tone_curve, ImageView& image) {
  const ArvBufferStatus status = arv_buffer_get_status(buffer);
  if (status != ARV_BUFFER_STATUS_SUCCESS) return WhyIncomplete(status);
  const auto format = PixelFormatOfGenicam(arv_buffer_get_image_pixel_format(buffer));
  if (!format.has_value()) return "it came in a format that was not asked for";
  gint x_padding = 0, y_padding = 0;
  arv_buffer_get_image_padding(buffer, &x_padding, &y_padding);
  const int width = arv_buffer_get_image_width(buffer), height = arv_buffer_get_image_height(buffer);
  if (!SizeIsValid(format.value(), width, height) || x_padding < 0) return "it has an impossible size";
  std::size_t size = 0;
  const auto* bytes = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &size));
  const std::ptrdiff_t stride = PlaneShapes(format.value(), width, height).front().row_bytes + x_padding;
  // The padding of the last row may be left out.
  if (bytes == nullptr || static_cast<std::ptrdiff_t>(size) + x_padding < stride * height)
    return "only " + std::to_string(size) + " bytes of it came";
  const std::array<Plane, 1> planes{{{bytes, stride}}};
  image = ImageView(format.value(), width, height, planes, tone_curve);
  return {};
}

}  // namespace

AravisSource::AravisSource(AravisOptions options, Clock clock)
    : options_(std::move(options)), clock_(std::move(clock)) {
  // For tests and for trying things out: a camera of Aravis within this process.
  if (options_.camera.device == "Fake_1") arv_enable_interface("Fake");
}

AravisSource::~AravisSource() {
  LetGo(false);
  // The process may be about to end, and must not wait for a camera that does not answer: the thread holds all it
  // needs.
  if (letting_go_.joinable() && has_let_go_.wait_for(kPatience) != std::future_status::ready) letting_go_.detach();
}

void AravisSource::Interrupt() {
  const std::lock_guard lock(session_mutex_);
  interrupted_ = true;
  if (session_) session_->Interrupt();
}

void AravisSource::LetGo(bool is_gone) {
  std::shared_ptr<AravisSession> session;
  {
    const std::lock_guard lock(session_mutex_);
    session = std::move(session_);
  }
  if (!session) return;
  std::promise<void> done;
  has_let_go_ = done.get_future();
  letting_go_ = std::jthread([session = std::move(session), is_gone, done = std::move(done)]() mutable {
    pthread_setname_np(pthread_self(), "chq-letgo");
    session->Close(is_gone);
    session.reset();
    done.set_value();
  });
}

bool AravisSource::HasLetGo() {
  if (!letting_go_.joinable()) return true;
  if (has_let_go_.wait_for(milliseconds(0)) != std::future_status::ready) return false;
  letting_go_.join();
  return true;
}

std::string AravisSource::Open() {
  LetGo(false);
  interrupted_ = false;
  // Two connections to one camera would take it from each other.
  if (letting_go_.joinable()) has_let_go_.wait_for(kPatience);
  if (!HasLetGo()) return "the camera " + device_->id + " does not answer; letting go of it first";
  remarks_.clear();
  try {
    OpenCamera();
  } catch (const CameraNotReady& trouble) {
    return trouble.what();
  }
  const bool delivers_by_itself = options_.trigger != TriggerKind::kHardware && rate_hz_ > 0;
  const MonotonicTime now = clock_.monotonic();
  silence_.Opened(microseconds(delivers_by_itself ? std::llround(1e6 / rate_hz_) : 0), now);
  next_trigger_ = now;
  ids_ = {};
  fit_ = {};
  return {};
}

void AravisSource::OpenCamera() {
  const CameraOptions& wanted = options_.camera;
  AravisFound found = FindAravisDevice(ListAravisDevices(), wanted.device, wanted.places.device, device_);
  // A camera behind a router does not hear us ask who is there.
  const bool ask_by_address = !found.device && !device_ && IsIpAddress(wanted.device);
  if (!found.device && !ask_by_address) throw CameraNotReady(found.problem);
  const std::string name = found.device ? found.device->id : wanted.device;
  ArvError error;
  ObjectHandle<ArvCamera> camera(arv_camera_new(name.c_str(), error.Receive()));
  if (!camera) throw CameraNotReady(wanted.places.device + ": " + name + " cannot be opened: " + error.message());
  if (arv_camera_is_gv_device(camera.get()) != 0 &&
      arv_gv_device_is_controller(ARV_GV_DEVICE(arv_camera_get_device(camera.get()))) == 0)
    throw CameraNotReady("another program controls the camera " + name + "; end that one");
  AravisSetUp set_up = SetUpAravis(camera.get(), options_);
  rate_hz_ = set_up.rate_hz;
  remarks_ = std::move(set_up.remarks);
  gint x = 0, y = 0;
  arv_camera_get_region(camera.get(), &x, &y, &width_, &height_, error.Receive());
  error.Check("reading the region");
  const char* format = arv_camera_get_pixel_format_as_string(camera.get(), error.Receive());
  error.Check("reading the pixel format");
  format_ = format;
  auto session = AravisSession::Start(std::move(camera), wanted.buffers, options_.packet_resend);
  if (found.device) device_ = std::move(found.device);
  if (!device_) device_ = AravisDevice{name, {}, {}, {}, name, {}, "GigEVision"};
  const std::lock_guard lock(session_mutex_);
  session_ = std::move(session);
}

CaptureResult AravisSource::Lost(const std::string& why) {
  LetGo(true);
  return {CaptureStatus::kDisconnected, {}, device_->id + ": " + why};
}

std::string AravisSource::TriggerIfDue(MonotonicTime now) {
  if (options_.trigger != TriggerKind::kSoftware || now < next_trigger_) return {};
  const microseconds period(std::llround(1e6 / rate_hz_));
  next_trigger_ = std::max(next_trigger_ + period, now);
  return session_->Trigger();
}

CaptureResult AravisSource::Next(milliseconds timeout) {
  if (!session_) return {CaptureStatus::kDisconnected, {}, "the camera is not open"};
  const MonotonicTime deadline = clock_.monotonic() + timeout;
  if (interrupted_.exchange(false)) return {CaptureStatus::kTimeout, {}, {}};
  while (true) {
    if (ArvBuffer* buffer = session_->Pop(); buffer != nullptr) {
      silence_.Alive(clock_.monotonic());
      return Take(buffer);
    }
    const MonotonicTime now = clock_.monotonic();
    if (const std::string wrong = TriggerIfDue(now); !wrong.empty()) return Lost("it cannot be triggered: " + wrong);
    // While frames that are under way hold every buffer, the camera cannot deliver.
    if (session_->queued() <= 0) silence_.Alive(now, false);
    if (silence_.IsSilent(now)) return Lost(silence_.Message(now));
    if (now >= deadline) return {CaptureStatus::kTimeout, {}, {}};
    microseconds wait = std::min<microseconds>(deadline - now, silence_.Left(now));
    if (options_.trigger == TriggerKind::kSoftware) wait = std::min<microseconds>(wait, next_trigger_ - now);
    switch (session_->Wait(wait)) {
      case AravisSession::Woken::kByInterrupt: interrupted_ = false; return {CaptureStatus::kTimeout, {}, {}};
      case AravisSession::Woken::kByLoss: return Lost("it does not answer any more, or another program took it");
      default: break;
    }
  }
}

CaptureResult AravisSource::Take(ArvBuffer* buffer) {
  CaptureResult result;
  const std::uint64_t number = ids_.Number(arv_buffer_get_frame_id(buffer));
  result.message = Look(buffer, options_.camera.tone_curve, result.frame.image);
  if (!result.message.empty()) {
    session_->GiveBack(buffer);
    result.status = CaptureStatus::kCorrupt;
    result.message.insert(0, "frame " + std::to_string(number) + ": ");
    return result;
  }
  result.status = CaptureStatus::kFrame;
  result.frame.sequence = number;
  SetTimes(buffer, result.frame);
  result.frame.lease = session_->Lend(buffer);
  return result;
}

void AravisSource::SetTimes(ArvBuffer* buffer, Frame& frame) {
  const MonotonicTime now = clock_.monotonic();
  const UtcTime now_utc = clock_.utc();
  // Aravis notes when the first packet came, by the wall clock; where that stepped since, now stands for it.
  const microseconds first_packet(arv_buffer_get_system_timestamp(buffer) / 1000);
  const microseconds ago =
      std::clamp<microseconds>(now_utc.time_since_epoch() - first_packet, microseconds(0), std::chrono::seconds(1));
  const MonotonicTime arrived = now - ago;
  frame.captured_monotonic = arrived;
  frame.captured_utc = now_utc - ago;
  const std::chrono::nanoseconds stamp(arv_buffer_get_timestamp(buffer));
  if (stamp.count() <= 0) return;  // the camera has no clock
  fit_.Add(stamp, arrived);
  frame.captured_monotonic = std::min(fit_.Map(stamp), now);
  frame.captured_utc = now_utc - (now - frame.captured_monotonic);
  frame.instant = ExposureInstant::kStart;
  if (!options_.ptp) return;
  const auto by_ptp = UtcOfPtp(stamp, frame.captured_utc, TaiMinusUtc(), kPtpTolerance);
  ptp_ = by_ptp.has_value();
  if (by_ptp) frame.captured_utc = *by_ptp;
}

std::string AravisSource::Health() const {
  if (!session_) return {};
  std::string text = session_->Statistics();
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (const auto error = fit_.error()) add("camera clock known to " + std::to_string(error->count()) + " us");
  if (options_.ptp) add(ptp_ ? "clock follows PTP" : "clock does not follow PTP yet");
  return text;
}

std::string AravisSource::Describe() const {
  const std::string wanted = options_.camera.device.empty() ? "of GenICam" : options_.camera.device;
  std::string text = "camera " + (device_ ? device_->id : wanted);
  if (!session_) return text;
  if (!device_->address.empty()) text += " at " + device_->address;
  text += ", " + SizeText(width_, height_) + " " + format_ + ", ";
  return text + (rate_hz_ > 0 ? RoundText(rate_hz_, 4) + " fps" : "when triggered");
}

}  // namespace chequer
