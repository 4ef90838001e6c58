#include "daemon/pipeline.h"

#include <pthread.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <future>
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
  PipelineState state;  ///< what came from the pipeline before and goes on to the next
  FrameSource* source;  ///< state's; null when it was handed on
  Publisher* publisher;
  PipelineEvents events;
  Clock clock;
  Progress progress;

  NewestQueue<CapturedFrame> queue;
  ReorderBuffer<Finished> finished;
  Shared<CaptureReport> capture_report;
  std::atomic<int> workers_left{0};
  std::stop_source stop;
  std::mutex failure_mutex;
  std::exception_ptr failure;
  std::atomic_flag told_scheduling;
  std::promise<void> end;
  const std::future<void> ended = end.get_future();

  // Of the publish thread alone.
  Statistics& statistics;  ///< state's
  FramePublisher frames;
  PosesMessage message;
  MonotonicTime next_status{};

  std::vector<std::jthread> threads;  ///< last: they use all of the above

  Impl(PipelineOptions given, PipelineState begin, PipelineEvents observer, Clock with)
      : options(std::move(given)),
        state(std::move(begin)),
        source(state.source.get()),
        publisher(state.publisher.get()),
        events(std::move(observer)),
        clock(std::move(with)),
        progress(options.workers),
        // While one worker is held up by a hard frame, each other can be one frame ahead of it, and no more.
        finished(2 * static_cast<std::uint64_t>(options.workers)),
        workers_left(options.workers),
        statistics(BeginStatistics()),
        frames(options.frames) {
    if (state.source_is_open && state.capture.state != CameraState::kEnded) {
      state.capture.state = CameraState::kRunning;
      state.capture.source = source->Describe();
    }
    capture_report.Update([&](CaptureReport& report) { report = state.capture; });
    message.camera = options.camera;
    next_status = clock.monotonic() + options.status_period;
  }

  Statistics& BeginStatistics() {
    const StatusConstants constants{options.version, options.camera, 1, options.workers};
    if (state.statistics)
      state.statistics->GoOnWith(constants);
    else
      state.statistics.emplace(constants, clock.monotonic());
    return *state.statistics;
  }

  void Start(std::vector<DetectFrame> detectors) {
    Launch("chq-publish", [this] {
      try {
        PublishAll();
      } catch (...) {
        Fail(std::current_exception());
      }
      if (events.finished) events.finished();
      end.set_value();
    });
    for (std::size_t i = 0; i < detectors.size(); ++i)
      Launch("chq-worker" + std::to_string(i), [this, index = static_cast<int>(i), detect = std::move(detectors[i])] {
        const std::vector<int>& cpus = options.scheduling.cpus;
        if (!cpus.empty()) TellOnce(PinThisThread(cpus[static_cast<std::size_t>(index) % cpus.size()]));
        Work(index, detect);
      });
    Launch("chq-capture", [this] { Capture(); });
  }

  template <typename Body>
  void Launch(std::string name, Body body) {
    threads.emplace_back([this, name = std::move(name), body = std::move(body)] {
      pthread_setname_np(pthread_self(), name.c_str());
      BecomeUrgent(!name.starts_with("chq-worker"));
      try {
        body();
      } catch (...) {
        Fail(std::current_exception());
      }
    });
  }

  void BecomeUrgent(bool more) {
    const int priority = options.scheduling.realtime_priority;
    if (priority > 0) TellOnce(MakeThisThreadRealtime(more ? priority + 1 : priority));
  }

  /// The frames are worked on all the same.
  void TellOnce(const std::string& problem) {
    if (!problem.empty() && !told_scheduling.test_and_set()) spdlog::warn("{}", problem);
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
    if (source != nullptr) source->Interrupt();
    const int discarded = queue.CloseAndDiscard();
    capture_report.Update([&](CaptureReport& report) { report.stopped += static_cast<std::uint64_t>(discarded); });
  }

  void Drain() {
    stop.request_stop();
    source->Interrupt();
  }

  bool Pass(CapturedFrame frame) {
    progress.frames.BeginUnlessBegun(clock.monotonic());
    if (options.when_busy == WhenBusy::kNewest) return queue.Put(std::move(frame));
    progress.capture.capturing.End();  // the next iteration begins it again
    return queue.PutWhenFree(std::move(frame));
  }

  void Capture() {
    const auto pass = [this](CapturedFrame frame) {
      const bool taken = Pass(std::move(frame));
      if (!taken) capture_report.Update([](CaptureReport& report) { ++report.stopped; });
      return taken;
    };
    CaptureLoop loop(options.capture, *source, pass, capture_report, state.sequence, progress.capture, clock);
    if (state.source_is_open) loop.TakeOpenSource();
    state.source_is_open = false;  // unless the loop ends well
    loop.Run(stop.get_token());
    state.source_is_open = loop.source_is_open();
    queue.Close();
  }

  void Work(int index, const DetectFrame& detect) {
    while (auto taken = queue.Take()) {
      const std::uint64_t ticket = taken->ticket;
      progress.worker(index).Begin(clock.monotonic());
      Finished result = Detect(detect, taken->item, state.superseded + taken->superseded);
      taken.reset();  // gives the buffer back to the source before it may have to wait for its turn
      progress.worker(index).End();
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
      progress.publishing.End();
      auto next = finished.Pop(std::max(microseconds(0), next_status - clock.monotonic()));
      progress.publishing.Begin(clock.monotonic());
      if (next) PublishFrame(std::move(*next));
      if (clock.monotonic() >= next_status) PublishStatus();
    }
    PublishStatus();
    progress.publishing.End();
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
    frames.Publish(message, *publisher, clock);
    frame.times.published = clock.monotonic();
    progress.frames.End();
    statistics.Published(frame.times, message.markers, frame.found.stats);
    TellReady();
  }

  void PublishStatus() {
    const MonotonicTime now = clock.monotonic();
    // On a grid of whole periods, so that the rate does not drift; a missed one is not made up for.
    next_status += options.status_period;
    if (next_status <= now) next_status = now + options.status_period;
    const CaptureReport capture = capture_report.Get();
    StatusMessage status = statistics.Finish(capture, state.superseded + queue.superseded(), queue.depth(), now);
    status.utc = clock.utc();
    status.publisher = publisher->health();
    status.publisher.sent += state.former_publishers.sent;
    status.publisher.failed += state.former_publishers.failed;
    if (status.camera_message.empty()) status.camera_message = frames.trouble();
    for (NamedCount& count : frames.TakeCounts()) status.detections.push_back(std::move(count));
    publisher->Publish(status);
    if (capture.state == CameraState::kWaiting && !capture.message.empty()) TellReady();
    if (events.status) events.status(status);
  }

  void TellReady() {
    if (std::exchange(state.told_ready, true)) return;
    if (events.ready) events.ready();
  }
};

Pipeline::Pipeline(PipelineOptions options, std::unique_ptr<FrameSource> source,
                   const std::function<DetectFrame()>& make_detect, std::unique_ptr<Publisher> publisher,
                   PipelineEvents events, Clock clock)
    : Pipeline(std::move(options), PipelineState{.source = std::move(source), .publisher = std::move(publisher)},
               make_detect, std::move(events), std::move(clock)) {}

Pipeline::Pipeline(PipelineOptions options, PipelineState state, const std::function<DetectFrame()>& make_detect,
                   PipelineEvents events, Clock clock)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(state), std::move(events), std::move(clock))) {
  std::vector<DetectFrame> detectors;
  for (int i = 0; i < impl_->options.workers; ++i) detectors.push_back(make_detect());
  impl_->Start(std::move(detectors));
}

Pipeline::~Pipeline() {
  impl_->Stop();
  impl_->threads.clear();
}

void Pipeline::Stop() { impl_->Stop(); }

void Pipeline::Drain() { impl_->Drain(); }

bool Pipeline::WaitForEnd(std::chrono::milliseconds timeout) const {
  return impl_->ended.wait_for(timeout) == std::future_status::ready;
}

void Pipeline::Join() {
  impl_->threads.clear();  // each joins as it dies
  if (impl_->failure) std::rethrow_exception(impl_->failure);
}

PipelineState Pipeline::TakeState() {
  impl_->state.capture = impl_->capture_report.Get();
  impl_->state.superseded += impl_->queue.superseded();
  impl_->source = nullptr;
  return std::move(impl_->state);
}

std::string Pipeline::Stuck(const ProgressLimits& limits) const {
  return impl_->progress.Stuck(impl_->clock.monotonic(), limits);
}

CameraState Pipeline::camera_state() const { return impl_->capture_report.Get().state; }

}  // namespace chequer
