#include "daemon/service.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

namespace chequer {
namespace {

constexpr std::chrono::milliseconds kLookWhileWaiting{250};

std::string Section(const DaemonConfig& config, const std::string& name) {
  const auto found = config.sections.find(name);
  return found == config.sections.end() ? std::string() : found->second;
}

bool SameSource(const DaemonConfig& one, const DaemonConfig& other) {
  if (Section(one, "capture") != Section(other, "capture")) return false;
  // The size that a camera is asked for may come from its calibration.
  const CameraOptions* camera = CameraOf(one.capture);
  const CameraOptions* next = CameraOf(other.capture);
  return camera == nullptr || (camera->width == next->width && camera->height == next->height);
}

bool SamePublisher(const DaemonConfig& one, const DaemonConfig& other) {
  return Section(one, "publish") == Section(other, "publish") && one.publish.prefix == other.publish.prefix;
}

/// What viewers get.
FrameViewerOptions ViewOf(const DaemonConfig& config) {
  FrameViewerOptions view{config.publish.url, config.publish.prefix, {}, config.detector};
  view.camera.camera = config.camera_name;
  view.camera.model = config.detector.camera;
  if (config.frames.world) view.camera.world_from_camera = config.frames.world->world_from_camera;
  for (const MarkerFamily& family : config.detector.families)
    view.camera.families.push_back({family.code.variant(), family.code.size(), family.side_m});
  return view;
}

/// More threads make a frame hardly faster: a part of the work on it is for one (a guess; two take 0.65 of the time of
/// one, measured with 50 boards in motion).
constexpr unsigned kMostThreads = 4;

/// Threads for one frame.
int ThreadsOf(const DaemonConfig& config, const PipelineOptions& pipeline, unsigned cores) {
  if (config.threads == ThreadsChoice::kNumber) return config.detector.threads;
  // Who is waited for is never late.
  if (pipeline.when_busy == WhenBusy::kWait) return 1;
  const std::size_t pinned = config.scheduling.cpus.size();
  if (pinned > 0) cores = static_cast<unsigned>(std::min<std::size_t>(pinned, cores));
  return static_cast<int>(std::clamp(cores, 1u, kMostThreads));
}

/// A detector for each worker, whose threads run as the worker does and which count what they do.
std::vector<DetectFrame> MakeDetectors(const DaemonConfig& config, const ServiceParts& parts, unsigned cores,
                                       PipelineOptions& pipeline) {
  const int workers = pipeline.workers;
  // Shared by the detectors and the pipeline, whichever goes first.
  auto done = std::make_shared<std::vector<std::atomic<std::uint64_t>>>(static_cast<std::size_t>(workers));
  pipeline.pieces_done = [done](int worker) { return (*done)[static_cast<std::size_t>(worker)].load(); };
  std::vector<DetectFrame> detectors;
  for (int worker = 0; worker < workers; ++worker) {
    DetectorOptions options = config.detector;
    options.threads = ThreadsOf(config, pipeline, cores);
    options.on_progress = [done, worker] { ++(*done)[static_cast<std::size_t>(worker)]; };
    options.on_thread_start = [scheduling = config.scheduling, worker, workers](int thread) {
      BecomeHelper(scheduling, worker, thread, workers);
    };
    detectors.push_back(parts.make_detect(options));
  }
  return detectors;
}

}  // namespace

/// All that can fail, made while the pipeline there is still runs.
struct Service::Prepared {
  std::vector<DetectFrame> detectors;
  std::unique_ptr<FrameSource> source;   ///< null: the one there is
  std::unique_ptr<Publisher> publisher;  ///< null: the one there is
  PipelineOptions options;
};

PipelineOptions MakePipelineOptions(const DaemonConfig& config, const std::string& version, unsigned cores) {
  const ReplayOptions& replay = config.capture.replay;
  const bool unlimited = config.capture.source == SourceKind::kReplay && replay.pace == ReplayPace::kUnlimited;
  PipelineOptions options;
  options.workers = config.workers > 0 ? config.workers : static_cast<int>(std::clamp(cores, 1u, 64u));
  options.when_busy =
      config.when_busy == WhenBusyChoice::kWait || (config.when_busy == WhenBusyChoice::kAuto && unlimited)
          ? WhenBusy::kWait
          : WhenBusy::kNewest;
  options.capture_times_are_live =
      !(config.capture.source == SourceKind::kReplay && replay.times == ReplayTimes::kRecorded);
  if (config.detector.camera)
    options.capture.size = FrameSize{config.detector.camera->width, config.detector.camera->height};
  options.scheduling = config.scheduling;
  options.camera = config.camera_name;
  options.version = version;
  options.frames = config.frames;
  options.families = config.detector.families;
  if (config.allow_view) options.view = ViewOf(config);
  return options;
}

std::string ChangedSections(const DaemonConfig& one, const DaemonConfig& other) {
  std::set<std::string> names;
  for (const DaemonConfig* config : {&one, &other})
    for (const auto& [name, text] : config->sections)
      if (Section(one, name) != Section(other, name)) names.insert(name);
  std::string list;
  for (const std::string& name : names) list.append(list.empty() ? "" : ", ").append(name);
  return list;
}

Service::Service(DaemonConfig config, std::string version, ServiceParts parts, PipelineEvents events, Clock clock)
    : version_(std::move(version)), parts_(std::move(parts)), events_(std::move(events)), clock_(std::move(clock)) {
  Prepared prepared = Prepare(config, true, true);
  PipelineState state;
  state.source = std::move(prepared.source);
  state.publisher = std::move(prepared.publisher);
  Start(std::move(config), std::move(state), std::move(prepared));
}

Service::~Service() = default;

FrameBudget Service::BudgetOf(const BudgetOptions& options, const PipelineOptions& pipeline) {
  if (options.choice == BudgetChoice::kUnits) return FrameBudget::Units(options.units);
  // Who is waited for is never late.
  if (options.choice == BudgetChoice::kUnlimited || pipeline.when_busy == WhenBusy::kWait || !parts_.measure_speed)
    return {};
  if (!speed_ || speed_->workers != pipeline.workers)
    speed_ = Speed{pipeline.workers, parts_.measure_speed(pipeline.workers)};
  return FrameBudget::Auto(speed_->units_per_second, pipeline.workers);
}

Service::Prepared Service::Prepare(const DaemonConfig& config, bool new_source, bool new_publisher) {
  CheckCpus(config.scheduling.cpus);
  Prepared prepared;
  const unsigned cores = std::thread::hardware_concurrency();
  prepared.options = MakePipelineOptions(config, version_, cores);
  prepared.options.budget = BudgetOf(config.budget, prepared.options);
  prepared.options.memory = config.memory;
  prepared.detectors = MakeDetectors(config, parts_, cores, prepared.options);
  FramePublisher{prepared.options.frames};  // throws here rather than when the pipeline there is has ended
  if (new_source) prepared.source = parts_.make_source(config.capture);
  if (new_publisher) prepared.publisher = parts_.make_publisher(config.publish);
  return prepared;
}

void Service::Start(DaemonConfig config, PipelineState state, Prepared prepared) {
  config_ = std::move(config);
  parts_.set_up_logging(config_);
  spdlog::info("chequerd {}: camera {} from {}, {} workers, LCM at {} as {}_POSES", version_, config_.camera_name,
               state.source->Describe(), prepared.options.workers, config_.publish.url, config_.publish.prefix);
  PipelineEvents events = events_;
  events.finished = [this] {
    if (!changing_ && events_.finished) events_.finished();
  };
  pipeline_ = std::make_unique<Pipeline>(
      std::move(prepared.options), std::move(state),
      [next = prepared.detectors.begin()]() mutable { return std::move(*next++); }, std::move(events), clock_);
}

PipelineState Service::Conclude() {
  changing_ = true;
  pipeline_->Drain();
  while (!pipeline_->WaitForEnd(kLookWhileWaiting))
    if (!parts_.while_waiting()) throw ReloadInterrupted{};
  try {
    pipeline_->Join();
  } catch (...) {
    changing_ = false;
    if (events_.finished) events_.finished();  // kept back above: it had failed on its own
    throw;
  }
  changing_ = false;
  return pipeline_->TakeState();
}

void Service::Reload(DaemonConfig next) {
  const bool new_source = !SameSource(config_, next);
  Prepared prepared = Prepare(next, new_source, !SamePublisher(config_, next));
  if (new_source && next.capture.source == SourceKind::kReplay) {
    // A recording needs no device that the camera there is may hold, so it can be tried before that is given up.
    CaptureOptions probe = next.capture;
    probe.replay.preload = Preload::kNo;
    if (const std::string problem = parts_.make_source(probe)->Open(); !problem.empty())
      throw std::runtime_error(problem);
  }
  PipelineState state = Conclude();
  if (new_source) {
    former_ = config_;
    state.ReplaceSource(std::move(prepared.source));
  }
  if (prepared.publisher) state.ReplacePublisher(std::move(prepared.publisher));
  try {
    Start(std::move(next), std::move(state), std::move(prepared));
  } catch (const std::exception& error) {
    throw ServiceLost(std::string("the changed configuration could not be started: ") + error.what());
  }
}

bool Service::GoesOn() {
  try {
    pipeline_->Join();
    return false;
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    // What no waiting repairs. Had the camera ever been opened, Settle would have forgotten the former configuration.
    if (!former_) throw;
    spdlog::error("the reloaded camera can never work: {}; the configuration before it is in force again",
                  error.what());
  }
  DaemonConfig former = *std::exchange(former_, std::nullopt);
  PipelineState state = pipeline_->TakeState();
  Prepared prepared = Prepare(former, true, !SamePublisher(config_, former));
  state.ReplaceSource(std::move(prepared.source));
  if (prepared.publisher) state.ReplacePublisher(std::move(prepared.publisher));
  Start(std::move(former), std::move(state), std::move(prepared));
  return true;
}

void Service::Settle() {
  if (former_ && pipeline_->camera_state() == CameraState::kRunning) former_.reset();
}

void Service::Stop() { pipeline_->Stop(); }

void Service::Join() { pipeline_->Join(); }

}  // namespace chequer
