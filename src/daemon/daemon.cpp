#include "daemon/daemon.h"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "capture/source_factory.h"
#include "core/unique_fd.h"
#include "daemon/notify.h"
#include "publish/lcm_publisher.h"

namespace chequer {
namespace {

UniqueFd Checked(int fd, const char* what) {
  if (fd < 0) throw std::system_error(errno, std::generic_category(), what);
  return UniqueFd(fd);
}

/// Blocks the signals that end the daemon, here and in every thread started later, and gives them as a descriptor.
UniqueFd TakeSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return Checked(signalfd(-1, &signals, SFD_CLOEXEC), "signalfd");
}

/// Waits until either can be read; whether it is the first.
bool WaitForFirst(const UniqueFd& first, const UniqueFd& second) {
  std::array<pollfd, 2> waiting{{{first.get(), POLLIN, 0}, {second.get(), POLLIN, 0}}};
  while (poll(waiting.data(), waiting.size(), -1) < 0)
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "poll");
  return waiting[0].revents != 0;
}

/// What the log says of a whole run.
std::string Summary(const StatusMessage& status) {
  std::string text = std::to_string(status.frames_published) + " frames published, " +
                     std::to_string(status.frames_dropped) + " dropped";
  const char* separator = ": ";
  for (const NamedCount& drop : status.drops) {
    if (drop.count == 0) continue;
    text += separator + drop.name + " " + std::to_string(drop.count);
    separator = ", ";
  }
  if (status.publisher.failed > 0)
    text += "; LCM did not take " + std::to_string(status.publisher.failed) + " messages";
  return text;
}

/// @param last gets each status; to be read when the pipeline has ended.
PipelineEvents MakeEvents(const UniqueFd& finished, StatusMessage& last) {
  PipelineEvents events;
  events.ready = NotifyReady;
  events.status = [&last](const StatusMessage& status) {
    last = status;
    NotifyStatus(StatusLine(status));
    NotifyAlive();
  };
  events.finished = [&finished] { eventfd_write(finished.get(), 1); };
  return events;
}

}  // namespace

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
  options.camera = config.camera_name;
  options.version = version;
  return options;
}

DetectFrame MakeDetectFrame(const DetectorOptions& options) {
  // Shared because std::function must be copyable; there is one owner.
  return [detector = std::make_shared<Detector>(options)](const ImageView& image, DetectedFrame& found) {
    detector->Detect(image, found.markers);
    found.stats = detector->stats();
  };
}

void RunDaemon(const DaemonConfig& config, const std::string& version) {
  const UniqueFd signals = TakeSignals();
  const UniqueFd finished = Checked(eventfd(0, EFD_CLOEXEC), "eventfd");
  StatusMessage last_status;
  const PipelineOptions options = MakePipelineOptions(config, version, std::thread::hardware_concurrency());
  std::unique_ptr<FrameSource> source = MakeSource(config.capture);
  spdlog::info("chequerd {}: camera {} from {}, {} workers, LCM at {} as {}_POSES", version, config.camera_name,
               source->Describe(), options.workers, config.publish.url, config.publish.prefix);
  Pipeline pipeline(
      options, std::move(source), [&] { return MakeDetectFrame(config.detector); },
      std::make_unique<LcmPublisher>(config.publish), MakeEvents(finished, last_status));
  if (WaitForFirst(signals, finished)) {
    signalfd_siginfo info{};
    const bool known = read(signals.get(), &info, sizeof info) == sizeof info;
    spdlog::info("stopping on {}", known && info.ssi_signo == SIGINT ? "SIGINT" : "SIGTERM");
  }
  NotifyStopping();
  pipeline.Stop();
  pipeline.Join();
  spdlog::info("stopped; {}", Summary(last_status));
}

}  // namespace chequer
