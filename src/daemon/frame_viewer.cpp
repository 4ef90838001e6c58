#include "daemon/frame_viewer.h"

#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <span>
#include <system_error>
#include <utility>

#include "daemon/marker_detail.h"
#include "daemon/preview.h"
#include "daemon/view_requests.h"
#include "publish/ask_channel.h"
#include "publish/channels.h"
#include "publish/lcm_sink.h"
#include "publish/lcm_url.h"
#include "publish/wire_view.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Kind = ViewRequests::Kind;

/// Requests that are read at once; then others wait, so that who floods the channel takes next to no time.
constexpr int kMostAtOnce = 16;
constexpr milliseconds kListenPause{50};
/// Between attempts at hearing requests where the group cannot be joined.
constexpr milliseconds kListenRetry{5000};

/// Lets all other threads go first, but not without end: on a computer that is always busy, who looks is to see
/// something. A worker that wakes takes the processor from it at once. Where that is refused, it runs as they do.
void GiveWayToOthers() {
  constexpr int kNice = 10;  // a tenth of a worker's share where both want one processor
  const sched_param none{};
  pthread_setschedparam(pthread_self(), SCHED_BATCH, &none);
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
}

/// Time of a processor that the calling thread has taken.
microseconds ThreadTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) +
         std::chrono::duration_cast<microseconds>(std::chrono::nanoseconds(time.tv_nsec));
}

}  // namespace

struct FrameViewer::Impl {
  FrameViewerOptions options;
  Clock clock;
  LcmUrl url;
  AskListener listener;
  ViewRequests requests;
  UniqueFd wake;
  std::unique_ptr<LcmSink> sink;         ///< while somebody looks
  std::optional<PreviewMaker> previews;  ///< while somebody looks
  std::optional<MarkerDetail> details;   ///< while somebody looks
  MonotonicTime listen_again{};

  mutable std::mutex mutex;
  std::optional<ViewedFrame> waiting;  ///< guarded by mutex, as all below
  std::optional<MarkerChoice> choice;
  bool closed = false;

  Impl(FrameViewerOptions given, Clock with)
      : options(std::move(given)),
        clock(std::move(with)),
        url(ParseLcmUrl(options.url, LcmDirection::kPublish)),
        listener(url, options.prefix),
        wake(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (!wake.valid()) throw std::system_error(errno, std::generic_category(), "eventfd");
  }

  void Wake() const {
    const std::uint64_t one = 1;
    if (write(wake.get(), &one, sizeof one) < 0) return;  // it is awake already
  }

  /// Waits for a request, a frame, or until something runs out or is due.
  void Wait() {
    const MonotonicTime now = clock.monotonic();
    const bool listens = listener.fd() >= 0 && now >= listen_again;
    milliseconds timeout{-1};
    if (requests.Any()) timeout = milliseconds(200);
    if (listener.fd() < 0) timeout = requests.Any() ? timeout : kListenRetry;
    if (listener.fd() >= 0 && !listens)
      timeout = std::max(milliseconds(1), std::chrono::ceil<milliseconds>(listen_again - now));
    std::array<pollfd, 2> sources{{{wake.get(), POLLIN, 0}, {listens ? listener.fd() : -1, POLLIN, 0}}};
    poll(sources.data(), sources.size(), static_cast<int>(timeout.count()));
    std::uint64_t count = 0;
    if (read(wake.get(), &count, sizeof count) < 0 && errno != EAGAIN)
      throw std::system_error(errno, std::generic_category(), "eventfd");
  }

  void Listen() {
    const MonotonicTime now = clock.monotonic();
    if (now < listen_again) return;
    int heard = 0;
    while (heard < kMostAtOnce) {
      const auto message = listener.Next();
      if (!message) break;
      requests.Take(*message, now);
      ++heard;
    }
    if (heard > 0) listen_again = now + kListenPause;
    requests.Expire(now);
  }

  bool Send(std::string_view suffix, std::span<const std::uint8_t> bytes) {
    std::string problem;
    if (!sink) sink = OpenLcmSink(url, clock, problem);
    return sink && sink->Send(ChannelName(options.prefix, suffix), bytes).empty();
  }

  void SendCamera() {
    const MonotonicTime now = clock.monotonic();
    if (!requests.IsDue(Kind::kCamera, now)) return;
    options.camera.utc = clock.utc();
    Send(kCameraSuffix, EncodeView(options.camera));
    requests.Done(Kind::kCamera, now, microseconds{0});
  }

  void SendPreview(const Frame& frame, const AskMessage& ask) {
    if (!previews) previews.emplace();
    Preview preview = previews->Make(frame.image, ask.preview->region, ask.preview->width);
    if (preview.jpeg.empty()) return;
    PreviewMessage message{.captured_utc = frame.captured_utc,
                           .sequence = frame.sequence,
                           .camera = options.camera.camera,
                           .asker = ask.asker,
                           .image_width = frame.image.width(),
                           .image_height = frame.image.height(),
                           .region = preview.region,
                           .width = preview.width,
                           .height = preview.height,
                           .jpeg = std::move(preview.jpeg)};
    Send(kPreviewSuffix, EncodeView(message));
  }

  void SendDetail(const ViewedFrame& viewed, const AskMessage& ask) {
    DetailMessage message;
    if (viewed.chosen) {
      if (!details) details.emplace(options.detector);
      message = details->Look(viewed.frame.image, *viewed.chosen);
    } else {
      message.message = "not found in this frame";
    }
    message.captured_utc = viewed.frame.captured_utc;
    message.sequence = viewed.frame.sequence;
    message.camera = options.camera.camera;
    message.asker = ask.asker;
    if (!message.found) {
      message.family = ask.detail->family;
      message.id = ask.detail->id;
    }
    Send(kDetailSuffix, EncodeView(message));
  }

  /// Answers with this frame what is due.
  void Answer(const ViewedFrame& viewed) {
    const MonotonicTime now = clock.monotonic();
    for (const Kind kind : {Kind::kPreview, Kind::kDetail}) {
      if (!requests.IsDue(kind, now)) continue;
      const microseconds before = ThreadTime();
      const AskMessage ask = *requests.Next(kind);
      if (kind == Kind::kPreview)
        SendPreview(viewed.frame, ask);
      else
        SendDetail(viewed, ask);
      requests.Done(kind, now, ThreadTime() - before);
    }
  }

  std::optional<ViewedFrame> TakeFrame() {
    const std::lock_guard lock(mutex);
    return std::exchange(waiting, std::nullopt);
  }

  /// Nobody looks any more: nothing is kept.
  void Rest() {
    sink.reset();
    previews.reset();
    details.reset();
  }
};

FrameViewer::FrameViewer(FrameViewerOptions options, Clock clock)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(clock))) {}

FrameViewer::~FrameViewer() = default;

std::optional<MarkerPose> FrameViewer::Choose(const std::vector<MarkerPose>& markers) const {
  const std::lock_guard lock(impl_->mutex);
  if (!impl_->choice) return std::nullopt;
  const MarkerPose* chosen = FindChoice(*impl_->choice, markers);
  return chosen == nullptr ? std::nullopt : std::optional(*chosen);
}

void FrameViewer::Offer(ViewedFrame frame) {
  std::optional<ViewedFrame> old(std::move(frame));  // dies after the lock is released
  {
    const std::lock_guard lock(impl_->mutex);
    if (impl_->closed) return;
    std::swap(old, impl_->waiting);
    wanted_from_us_ = kNever;  // until this one is answered
  }
  impl_->Wake();
}

void FrameViewer::Run() {
  GiveWayToOthers();
  while (true) {
    impl_->Wait();
    impl_->Listen();
    impl_->SendCamera();
    bool awaits_frame = false;
    if (const auto viewed = impl_->TakeFrame()) impl_->Answer(*viewed);
    const auto next = impl_->requests.NextFrame();
    if (!impl_->requests.Any()) impl_->Rest();
    const std::lock_guard lock(impl_->mutex);
    if (impl_->closed) return;
    awaits_frame = next && !impl_->waiting;
    const AskMessage* detail = impl_->requests.Next(Kind::kDetail);
    impl_->choice = detail == nullptr ? std::nullopt : detail->detail;
    wanted_from_us_ = awaits_frame ? next->time_since_epoch().count() : kNever;
  }
}

void FrameViewer::Close() {
  std::optional<ViewedFrame> old;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->closed = true;
    wanted_from_us_ = kNever;
    std::swap(old, impl_->waiting);
  }
  impl_->Wake();
}

}  // namespace chequer
