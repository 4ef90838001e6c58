#include "daemon/pipeline.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "daemon/newest_queue.h"
#include "daemon/reorder_buffer.h"
#include "daemon/shared.h"
#include "daemon/statistics.h"

namespace chequer {
namespace {

using std::chrono::microseconds;

/// A frame that a worker is done with: all but its pixels, whose buffer went back to the source.
struct Finished {
  UtcTime captured_utc{};
  MonotonicTime captured_monotonic{};
  ExposureInstant instant = ExposureInstant::kUnknown;
  std::uint64_t sequence = 0;
  std::uint64_t frames_dropped = 0;
  FrameSize size;
  FrameTimes times;
  DetectedFrame found;
};

}  // namespace

struct Pipeline::Impl {
  PipelineOptions options;
  std::unique_ptr<FrameSource> source;
  std::unique_ptr<Publisher> publisher;
  PipelineEvents events;
  Clock clock;

  NewestQueue<CapturedFrame> queue;
  ReorderBuffer<Finished> finished;
  Shared<CaptureReport> capture_report;
  std::atomic<int> workers_left{0};
  std::stop_source stop;
  std::mutex failure_mutex;
  std::exception_ptr failure;

  // Of the publish thread alone.
  Statistics statistics;
  PosesMessage message;
  bool told_ready = false;
  MonotonicTime next_status{};

  std::vector<std::jthread> threads;  ///< last: they use all of the above

  Impl(PipelineOptions given, std::unique_ptr<FrameSource> from, std::unique_ptr<Publisher> to, PipelineEvents observer,
       Clock with)
      : options(std::move(given)),
        source(std::move(from)),
        publisher(std::move(to)),
        events(std::move(observer)),
        clock(std::move(with)),
        // While one worker is held up by a hard frame, each other can be one frame ahead of it, and no more.
        finished(2 * static_cast<std::uint64_t>(options.workers)),
        workers_left(options.workers),
        statistics({options.version, options.camera, 1, options.workers}, clock.monotonic()) {
    message.camera = options.camera;
    next_status = clock.monotonic() + options.status_period;
  }

  void Start(std::vector<DetectFrame> detectors) {
    Launch("chq-publish", [this] {
      try {
        PublishAll();
      } catch (...) {
        Fail(std::current_exception());
      }
      if (events.finished) events.finished();
    });
    for (std::size_t i = 0; i < detectors.size(); ++i)
      Launch("chq-worker" + std::to_string(i), [this, detect = std::move(detectors[i])] { Work(detect); });
    Launch("chq-capture", [this] { Capture(); });
  }

  template <typename Body>
  void Launch(std::string name, Body body) {
    threads.emplace_back([this, name = std::move(name), body = std::move(body)] {
      pthread_setname_np(pthread_self(), name.c_str());
      try {
        body();
      } catch (...) {
        Fail(std::current_exception());
      }
    });
  }

  /// A thread ended with an error: no other can go on.
  void Fail(std::exception_ptr error) {
    {
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::move(error);
    }
    Stop();
    finished.Abort();
  }

  void Stop() {
    stop.request_stop();
    source->Interrupt();
    const int discarded = queue.CloseAndDiscard();
    capture_report.Update([&](CaptureReport& report) { report.stopped += static_cast<std::uint64_t>(discarded); });
  }

  void Capture() {
    const auto pass = [this](CapturedFrame frame) {
      const bool wait = options.when_busy == WhenBusy::kWait;
      const bool taken = wait ? queue.PutWhenFree(std::move(frame)) : queue.Put(std::move(frame));
      if (!taken) capture_report.Update([](CaptureReport& report) { ++report.stopped; });
      return taken;
    };
    CaptureLoop(options.capture, *source, pass, capture_report, clock).Run(stop.get_token());
    queue.Close();
  }

  void Work(const DetectFrame& detect) {
    while (auto taken = queue.Take()) {
      const std::uint64_t ticket = taken->ticket;
      Finished result = Detect(detect, taken->item, taken->superseded);
      taken.reset();  // gives the buffer back to the source before it may have to wait for its turn
      finished.Push(ticket, std::move(result));
    }
    if (--workers_left == 0) finished.Close();
  }

  Finished Detect(const DetectFrame& detect, const CapturedFrame& captured, std::uint64_t superseded) const {
    const Frame& frame = captured.frame;
    Finished result;
    result.captured_utc = frame.captured_utc;
    result.captured_monotonic = frame.captured_monotonic;
    result.instant = frame.instant;
    result.sequence = frame.sequence;
    result.frames_dropped = captured.dropped_before + superseded;
    result.size = {frame.image.width(), frame.image.height()};
    result.times.captured = options.capture_times_are_live ? frame.captured_monotonic : captured.arrived;
    result.times.started = clock.monotonic();
    detect(frame.image, result.found);
    result.times.detected = clock.monotonic();
    return result;
  }

  void PublishAll() {
    while (!finished.IsDone()) {
      auto next = finished.Pop(std::max(microseconds(0), next_status - clock.monotonic()));
      if (next) PublishFrame(std::move(*next));
      if (clock.monotonic() >= next_status) PublishStatus();
    }
    PublishStatus();
  }

  void PublishFrame(Finished frame) {
    frame.times.ordered = clock.monotonic();
    message.captured_utc = frame.captured_utc;
    message.captured_monotonic = frame.captured_monotonic;
    message.instant = frame.instant;
    message.sequence = frame.sequence;
    message.frames_dropped = frame.frames_dropped;
    message.image_width = frame.size.width;
    message.image_height = frame.size.height;
    message.markers = std::move(frame.found.markers);
    message.published_utc = clock.utc();
    message.published_monotonic = clock.monotonic();
    publisher->Publish(message);
    frame.times.published = clock.monotonic();
    statistics.Published(frame.times, message.markers.size(), frame.found.stats);
    TellReady();
  }

  void PublishStatus() {
    const MonotonicTime now = clock.monotonic();
    // On a grid of whole periods, so that the rate does not drift; a missed one is not made up for.
    next_status += options.status_period;
    if (next_status <= now) next_status = now + options.status_period;
    const CaptureReport capture = capture_report.Get();
    StatusMessage status = statistics.Finish(capture, queue.superseded(), queue.depth(), now);
    status.utc = clock.utc();
    status.publisher = publisher->health();
    publisher->Publish(status);
    if (capture.state == CameraState::kWaiting && !capture.message.empty()) TellReady();
    if (events.status) events.status(status);
  }

  void TellReady() {
    if (std::exchange(told_ready, true)) return;
    if (events.ready) events.ready();
  }
};

Pipeline::Pipeline(PipelineOptions options, std::unique_ptr<FrameSource> source,
                   const std::function<DetectFrame()>& make_detect, std::unique_ptr<Publisher> publisher,
                   PipelineEvents events, Clock clock)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(source), std::move(publisher), std::move(events),
                                   std::move(clock))) {
  std::vector<DetectFrame> detectors;
  for (int i = 0; i < impl_->options.workers; ++i) detectors.push_back(make_detect());
  impl_->Start(std::move(detectors));
}

Pipeline::~Pipeline() {
  impl_->Stop();
  impl_->threads.clear();
}

void Pipeline::Stop() { impl_->Stop(); }

void Pipeline::Join() {
  impl_->threads.clear();  // each joins as it dies
  if (impl_->failure) std::rethrow_exception(impl_->failure);
}

}  // namespace chequer
