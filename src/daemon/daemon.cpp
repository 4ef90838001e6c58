#include "daemon/daemon.h"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/signalfd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "capture/source_factory.h"
#include "chequer/detect_trace.h"
#include "core/unique_fd.h"
#include "daemon/log_event.h"
#include "daemon/logging.h"
#include "daemon/machine_speed.h"
#include "daemon/mailbox.h"
#include "daemon/metrics.h"
#include "daemon/notify.h"
#include "daemon/report.h"
#include "daemon/restart_back_off.h"
#include "daemon/watchdog.h"
#include "publish/lcm_publisher.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// How long a stop waits for a frame that is worked on, or a camera that is being opened; and then for what was
/// finished to be sent. Together two seconds: systemd kills after five.
constexpr milliseconds kStopPatience{1200};
constexpr milliseconds kSendPatience{800};

sigset_t HeededSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  return signals;
}

/// The signals the daemon heeds, as a descriptor.
UniqueFd TakeSignals() {
  const sigset_t signals = HeededSignals();
  UniqueFd fd(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!fd.valid()) throw std::system_error(errno, std::generic_category(), "signalfd");
  return fd;
}

/// The next signal that has come; 0 if none has.
int NextSignal(const UniqueFd& signals) {
  signalfd_siginfo info{};
  return read(signals.get(), &info, sizeof info) == sizeof info ? static_cast<int>(info.ssi_signo) : 0;
}

/// Waits until one of them can be read, at most that long.
void WaitForEither(int one, int other, milliseconds timeout) {
  std::array<pollfd, 2> waiting{{{one, POLLIN, 0}, {other, POLLIN, 0}}};
  if (poll(waiting.data(), waiting.size(), static_cast<int>(timeout.count())) < 0 && errno != EINTR)
    throw std::system_error(errno, std::generic_category(), "poll");
}

ServiceParts RealParts(const std::string& version, std::function<bool()> while_waiting) {
  return {.make_source = [](const CaptureOptions& options) { return MakeSource(options); },
          .make_publisher = [](const LcmPublisherOptions& options) { return std::make_unique<LcmPublisher>(options); },
          .make_detect = MakeDetectFrame,
          .measure_speed = MeasureSpeed,
          .set_up_logging =
              [version](const DaemonConfig& config) { SetUpLogging(config.log, config.camera_name, version); },
          .while_waiting = std::move(while_waiting)};
}

/// The service and what is around it: signals, the service manager, metrics.
class Runner {
 public:
  Runner(const DaemonConfig& config, std::filesystem::path file, const std::string& version)
      : file_(std::move(file)), vigil_(WatchdogPeriod()) {
    if (const char* folder = std::getenv("RUNTIME_DIRECTORY")) runtime_folder_ = folder;
    if (!WaitAfterFailures()) return;
    metrics_ = std::make_unique<Metrics>(config.metrics);
    PipelineEvents events;
    events.ready = [this] { mailbox_.PutReady(); };
    events.status = [this](const StatusMessage& status) { mailbox_.Put(status); };
    events.finished = [this] { mailbox_.PutFinished(); };
    service_ = std::make_unique<Service>(config, version, RealParts(version, [this] { return GoesOnWaiting(); }),
                                         std::move(events));
  }

  void Run() {
    if (service_) {
      if (std::exchange(reload_at_once_, false)) Reload();
      while (stop_signal_ == 0 && Step()) {
      }
      Stop();
    }
    if (runtime_folder_) ForgetFailures(*runtime_folder_);
  }

 private:
  /// Whether the service is to be started: nobody asked to stop while it waited.
  bool WaitAfterFailures() {
    if (!runtime_folder_) return true;
    const seconds delay = DelayBeforeStart(*runtime_folder_, Clock::System().utc());
    if (delay == seconds(0)) return true;
    spdlog::warn("started again after a failure: waiting {} s", delay.count());
    NotifyStatus("started again after a failure: waiting " + std::to_string(delay.count()) + " s");
    NotifyStarting(delay + kStarting);
    const Clock clock = Clock::System();
    for (const MonotonicTime end = clock.monotonic() + delay; clock.monotonic() < end;) {
      WaitForEither(signals_.get(), mailbox_.fd(), std::chrono::ceil<milliseconds>(end - clock.monotonic()));
      if (!TakeSignal()) return false;
    }
    return true;
  }

  /// Heeds a signal if one has come; false if it asks to stop.
  bool TakeSignal() {
    const int signal = NextSignal(signals_);
    if (signal == SIGHUP) reload_at_once_ = true;
    if (signal == SIGINT || signal == SIGTERM) {
      spdlog::info("stopping on {}", signal == SIGINT ? "SIGINT" : "SIGTERM");
      stop_signal_ = signal;
    }
    return stop_signal_ == 0;
  }

  /// Ends the service; leaves the process where a thread of it does not end.
  void Stop() {
    NotifyStopping();
    service_->Stop();
    if (service_->WaitForEnd(kStopPatience)) {
      service_->Join();
      SayGoodbye();
      return;
    }
    LogEvent(LogLevel::kWarning, "abandoned", "stopping without waiting any longer: " + service_->UnderWay());
    const bool all_is_sent = service_->Abandon(kSendPatience);
    SayGoodbye();
    if (runtime_folder_) ForgetFailures(*runtime_folder_);
    // A log of LCM's is whole then; one that hangs would hold this up for ever.
    if (all_is_sent) std::fflush(nullptr);
    std::_Exit(kDaemonOk);
  }

  void SayGoodbye() {
    TakeMail();
    LogEvent(LogLevel::kInfo, "stopped", "stopped; " + Summary(last_status_), ReportFields(last_status_));
  }

  /// Waits for the next thing to do and does it; whether there is to be a next.
  bool Step() {
    WaitForEither(signals_.get(), mailbox_.fd(), vigil_.period());
    if (TakeMail().finished && !service_->GoesOn()) return false;
    service_->Settle();
    Look();
    if (!TakeSignal()) return false;
    if (std::exchange(reload_at_once_, false)) Reload();
    return true;
  }

  /// While a pipeline is awaited that is to end for another.
  bool GoesOnWaiting() {
    Look();
    return TakeSignal();
  }

  void Look() {
    vigil_.Look(service_->Stuck(vigil_.limits()), [this] {
      NotifyAlive();
      if (!ready_) NotifyStarting(kStarting);
    });
  }

  Mailbox::Mail TakeMail() {
    Mailbox::Mail mail = mailbox_.Take();
    if (mail.status) {
      last_status_ = *mail.status;
      NotifyStatus(StatusLine(last_status_) + refused_);
      metrics_->Update(last_status_);
      report_.Take(last_status_);
    }
    // Behind the status: who waited for the start to be over can read at once what is wrong.
    if (mail.ready && !std::exchange(ready_, true)) NotifyReady();
    return mail;
  }

  void Reload() {
    NotifyReloading();
    try {
      DaemonConfig next = LoadDaemonConfig(file_);
      const DaemonConfig before = service_->config();
      const std::string changed = ChangedSections(before, next);
      service_->Reload(next);
      if (changed.find("metrics") != std::string::npos) {
        metrics_.reset();  // first: the port may be the same
        metrics_ = std::make_unique<Metrics>(next.metrics);
      }
      refused_.clear();
      LogEvent(LogLevel::kInfo, "reloaded",
               "read " + file_.string() + " again; " + (changed.empty() ? "nothing" : changed) + " changed");
    } catch (const ReloadInterrupted&) {
      return;  // to stop
    } catch (const ServiceLost&) {
      throw;
    } catch (const std::runtime_error& error) {
      LogEvent(LogLevel::kError, "reload_refused",
               std::string("the changed configuration is refused, the former stays in force: ") + error.what());
      refused_ = std::string("; changed configuration refused: ") + error.what();
      NotifyStatus(StatusLine(last_status_) + refused_);
    }
    if (ready_) NotifyReady();
  }

  /// How long starting may take from the last sign of progress on.
  static constexpr seconds kStarting{30};

  const UniqueFd signals_ = TakeSignals();
  std::filesystem::path file_;
  Mailbox mailbox_;
  Watchdog vigil_;
  Report report_{Clock::System()};
  std::unique_ptr<Metrics> metrics_;
  StatusMessage last_status_;
  std::string refused_;  ///< why the last configuration was refused, for the service manager; else empty
  std::optional<std::filesystem::path> runtime_folder_;  ///< where starts are counted
  bool reload_at_once_ = false;                          ///< the configuration was changed after it was read
  int stop_signal_ = 0;                                  ///< that asked to stop
  bool ready_ = false;
  std::unique_ptr<Service> service_;  ///< last: its threads use the mailbox
};

}  // namespace

DetectFrame MakeDetectFrame(const DetectorOptions& options) {
  // Shared because std::function must be copyable; there is one owner.
  return [detector = std::make_shared<Detector>(options)](const ImageView& image, DetectedFrame& found) {
    DetectTrace trace;
    detector->set_budget(found.budget);
    DetectTrace* const traced = found.look ? &trace : nullptr;
    if (found.memory)
      detector->Detect(image, found.captured.time_since_epoch(), *found.memory, found.markers, traced);
    else
      detector->Detect(image, found.markers, traced);
    found.stats = detector->stats();
    if (found.look) found.look = LookAt(image, detector->options().families, found.markers, trace);
  };
}

void HoldSignals() {
  const sigset_t signals = HeededSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

void RunDaemon(const DaemonConfig& config, const std::filesystem::path& file, const std::string& version) {
  Runner(config, file, version).Run();
}

}  // namespace chequer
