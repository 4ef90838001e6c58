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

#include "daemon/hints.h"
#include "daemon/newest_queue.h"
#include "daemon/outbox.h"
#include "daemon/reorder_buffer.h"
#include "daemon/shared.h"
#include "daemon/statistics.h"

namespace chequer {
namespace {

using std::chrono::microseconds;

/// What waits to be sent at the end may take that long: a server that has stopped reading must not keep a daemon that
/// is to stop.
constexpr std::chrono::milliseconds kLastWords{500};

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
  PipelineEvents events;
  Clock clock;
  Progress progress;
  Outbox outbox;  ///< to state's publisher
  std::optional<FrameViewer> viewer;

  NewestQueue<CapturedFrame> queue;
  ReorderBuffer<Finished> finished;
  /// What the newest frame that is finished taught. A new pipeline begins without: whatever was changed may matter.
  struct Taught {
    std::uint64_t frames = 0;  ///< up to it, that were begun
    DetectorMemory memory;
  };
  Shared<Taught> taught;
  Shared<CaptureReport> capture_report;
  std::atomic<std::uint64_t> abandoned{0};  ///< frames that workers were given up with
  std::atomic<int> workers_left{0};
  std::atomic<bool> look_wanted{true};  ///< by the next frame: one a status is looked at more closely
  std::stop_source stop;
  std::mutex failure_mutex;
  std::exception_ptr failure;
  std::atomic_flag told_scheduling;
  std::atomic<bool> failed_to_start{false};
  std::atomic<int> threads_left;
  std::promise<void> sent_all, end;
  const std::future<void> all_is_sent = sent_all.get_future(), ended = end.get_future();
  mutable std::atomic<std::uint64_t> told_budget{0};

  // Of the publish thread alone.
  Statistics& statistics;  ///< state's
  FramePublisher frames;
  Hints hints;
  PosesMessage message;
  MonotonicTime next_status{};

  std::vector<std::jthread> threads;  ///< last: they use all of the above

  Impl(PipelineOptions given, PipelineState begin, PipelineEvents observer, Clock with)
      : options(std::move(given)),
        state(std::move(begin)),
        source(state.source.get()),
        events(std::move(observer)),
        clock(std::move(with)),
        progress(options.workers, options.pieces_done),
        outbox(*state.publisher,
               options.when_busy == WhenBusy::kWait ? Outbox::WhenFull::kWait : Outbox::WhenFull::kDropOldest,
               progress.sending, clock),
        // While one worker is held up by a hard frame, each other can be one frame ahead of it, and no more.
        finished(2 * static_cast<std::uint64_t>(options.workers)),
        workers_left(options.workers),
        threads_left(options.workers + (options.view ? 4 : 3)),
        statistics(BeginStatistics()),
        frames(options.frames),
        hints(options.families) {
    if (options.view) viewer.emplace(*options.view, clock);
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

  void Start(const std::function<DetectFrame()>& make_detect) {
    try {
      StartThreads(make_detect);
    } catch (...) {
      // Those that run would wait for the others for ever.
      failed_to_start = true;
      Stop();
      finished.Abort();
      outbox.Close();
      if (viewer) viewer->Close();
      threads.clear();
      throw;
    }
  }

  void StartThreads(const std::function<DetectFrame()>& make_detect) {
    Launch("chq-send", [this] {
      outbox.Run();
      sent_all.set_value();
    });
    Launch("chq-publish", [this] {
      try {
        PublishAll();
      } catch (...) {
        Fail(std::current_exception());
      }
      outbox.Close();
      if (viewer) viewer->Close();
    });
    if (viewer) Launch("chq-view", [this] { viewer->Run(); });
    for (int index = 0; index < options.workers; ++index)
      Launch("chq-worker" + std::to_string(index), [this, index, detect = make_detect()] {
        if (!options.scheduling.cpus.empty()) TellOnce(PinThisThread(CpuOf(options.scheduling, index)));
        Work(index, detect);
      });
    Launch("chq-capture", [this] { Capture(); });
  }

  template <typename Body>
  void Launch(std::string name, Body body) {
    threads.emplace_back([this, name = std::move(name), body = std::move(body)] {
      pthread_setname_np(pthread_self(), name.c_str());
      if (name != "chq-view") BecomeUrgent(!name.starts_with("chq-worker"));
      try {
        body();
      } catch (...) {
        Fail(std::current_exception());
      }
      if (--threads_left == 0) End();
    });
  }

  /// The last thread does this.
  void End() {
    if (!failed_to_start && events.finished) events.finished();
    end.set_value();
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
    queue.CloseAndDiscard();
    outbox.StopWaiting();
  }

  void Abandon() {
    abandoned = static_cast<std::uint64_t>(progress.busy_workers(clock.monotonic()));
    finished.Abort();
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
    const auto pass = [this](CapturedFrame frame) { return Pass(std::move(frame)); };
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
      Finished result = Detect(detect, taken->item, state.former_queues.superseded + taken->superseded);
      if (result.found.memory) Teach(ticket, *result.found.memory);
      auto viewed = KeptForView(taken->item.frame, result.found.markers);
      taken.reset();  // gives the buffer back to the source before it may have to wait for its turn
      progress.worker(index).End();
      progress.frames.Renew(clock.monotonic());  // it is published next
      finished.Push(ticket, std::move(result));
      if (viewed) viewer->Offer(std::move(*viewed));  // behind it: no pose waits for those who look
    }
    if (--workers_left == 0) finished.Close();
  }

  /// The frame with its buffer, where somebody looks and it is the turn of one.
  std::optional<ViewedFrame> KeptForView(Frame& frame, const std::vector<MarkerPose>& markers) const {
    if (!viewer || !viewer->WantsFrame(clock.monotonic())) return std::nullopt;
    return ViewedFrame{std::move(frame), viewer->Choose(markers)};
  }

  Finished Detect(const DetectFrame& detect, const CapturedFrame& captured, std::uint64_t superseded) {
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
    if (look_wanted.exchange(false)) result.found.look.emplace();
    result.found.budget = BudgetFor(captured.rate_hz);
    result.found.captured = frame.captured_monotonic;
    if (options.memory) taught.Update([&](const Taught& newest) { result.found.memory = newest.memory; });
    detect(frame.image, result.found);
    result.times.detected = clock.monotonic();
    return result;
  }

  /// Frames that were overtaken by later ones have nothing new to teach. Leaves what there was.
  void Teach(std::uint64_t ticket, DetectorMemory& memory) {
    taught.Update([&](Taught& newest) {
      if (ticket < newest.frames) return;
      newest.frames = ticket + 1;
      std::swap(newest.memory, memory);
    });
  }

  std::uint64_t BudgetFor(double rate_hz) const {
    const std::uint64_t units = options.budget.For(rate_hz);
    if (told_budget.exchange(units) != units)
      spdlog::info("a frame may take {}",
                   units == 0 ? "as much work as it takes" : fmt::format("{} units of work", units));
    return units;
  }

  void PublishAll() {
    while (!finished.IsDone()) {
      progress.publishing.End();
      auto next = finished.Pop(std::max(microseconds(0), next_status - clock.monotonic()));
      progress.publishing.Begin(clock.monotonic());
      if (next) PublishFrame(std::move(*next));
      if (clock.monotonic() >= next_status) PublishStatus();
    }
    progress.publishing.End();
    // So that the last status counts all. The end of a recording loses nothing; who is to stop does not wait for long.
    bool sent = false;
    while (!(sent = outbox.WaitUntilSent(kLastWords)) && !stop.stop_requested()) {
    }
    PublishStatus();
    if (sent) outbox.WaitUntilSent(kLastWords);
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
    frames.Publish(message, outbox, clock);
    outbox.EndFrame(frame.times);
    progress.frames.End();
    statistics.Published(message.markers, frame.found.stats);
    if (frame.found.look) hints.Take(*frame.found.look);
    TellReady();
  }

  /// Since the daemon started.
  QueueCounts CountFrames() const {
    QueueCounts counts = queue.counts();
    counts.came += state.former_queues.came;
    counts.superseded += state.former_queues.superseded;
    counts.discarded += state.former_queues.discarded + abandoned;
    return counts;
  }

  void PublishStatus() {
    const MonotonicTime now = clock.monotonic();
    // On a grid of whole periods, so that the rate does not drift; a missed one is not made up for.
    next_status += options.status_period;
    if (next_status <= now) next_status = now + options.status_period;
    for (const FrameTimes& times : outbox.TakeSent()) statistics.Sent(times);
    const CaptureReport capture = capture_report.Get();
    StatusMessage status = statistics.Finish(capture, CountFrames(), now);
    status.utc = clock.utc();
    status.publisher = outbox.health();
    status.publisher.sent += state.former_publishers.sent;
    status.publisher.failed += state.former_publishers.failed;
    if (status.camera_message.empty()) status.camera_message = frames.trouble();
    for (NamedCount& count : frames.TakeCounts()) status.detections.push_back(std::move(count));
    for (NamedCount& count : hints.TakeCounts()) status.detections.push_back(std::move(count));
    look_wanted = true;
    outbox.Publish(status);
    if (events.status) events.status(status);
    // A camera whose every frame is unusable is no reason to go on starting: what is wrong has just been said.
    if (capture.state != CameraState::kWaiting || !capture.message.empty()) TellReady();
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
  impl_->Start(make_detect);
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

std::string Pipeline::UnderWay() const { return impl_->progress.UnderWay(impl_->clock.monotonic()); }

bool Pipeline::Abandon(std::chrono::milliseconds timeout) {
  impl_->Abandon();
  return impl_->all_is_sent.wait_for(timeout) == std::future_status::ready;
}

void Pipeline::Join() {
  impl_->threads.clear();  // each joins as it dies
  if (impl_->failure) std::rethrow_exception(impl_->failure);
}

PipelineState Pipeline::TakeState() {
  impl_->state.capture = impl_->capture_report.Get();
  impl_->state.former_queues = impl_->CountFrames();
  impl_->state.former_publishers.failed += impl_->outbox.dropped();
  impl_->source = nullptr;
  return std::move(impl_->state);
}

std::string Pipeline::Stuck(const ProgressLimits& limits) const {
  return impl_->progress.Stuck(impl_->clock.monotonic(), limits);
}

CameraState Pipeline::camera_state() const { return impl_->capture_report.Get().state; }

}  // namespace chequer
