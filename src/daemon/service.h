#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/config.h"
#include "daemon/pipeline.h"

namespace chequer {

/// Where a service gets its parts from; tests hand in others.
struct ServiceParts {
  std::function<std::unique_ptr<FrameSource>(const CaptureOptions&)> make_source;
  std::function<std::unique_ptr<Publisher>(const LcmPublisherOptions&)> make_publisher;
  std::function<DetectFrame(const DetectorOptions&)> make_detect;
  /// How fast this machine works, units of DetectStats::work a second. Called once, where a budget hangs on it; left
  /// out: such a budget is unlimited.
  std::function<double(int workers)> measure_speed;
  /// Directs the log; called while no thread of the service runs.
  std::function<void(const DaemonConfig&)> set_up_logging;
  /// Called a few times a second while a pipeline is awaited that is to end for another: a camera that is being opened
  /// cannot be interrupted. False where that is to be awaited no longer, as the whole service is to stop.
  std::function<bool()> while_waiting;
};

/// Service::Reload did not come to its end: somebody asked to stop (ServiceParts::while_waiting).
struct ReloadInterrupted {};

/// Service::Reload ended one pipeline and could not start the next: there is no service any more.
class ServiceLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The pipeline that a configuration describes. @param cores of the machine, for the number of workers.
PipelineOptions MakePipelineOptions(const DaemonConfig& config, const std::string& version, unsigned cores);

/// Names of the tables that two configurations say different things in, such as "capture, log"; empty if there is none.
std::string ChangedSections(const DaemonConfig& one, const DaemonConfig& other);

/// A pipeline that can be given another configuration while it runs. One thread.
class Service {
 public:
  /// Starts. Throws std::runtime_error where the configuration cannot work on this machine.
  /// @param events of PipelineEvents; `finished` comes only for the end of the service, not of one of its pipelines.
  Service(DaemonConfig config, std::string version, ServiceParts parts, PipelineEvents events,
          Clock clock = Clock::System());
  /// Stops and joins.
  ~Service();

  /// Goes on with another configuration. The camera stays open where [capture] says the same, LCM where the publisher's
  /// options are the same; frames that were captured are published; counts and sequence numbers go on. Throws
  /// std::runtime_error, and changes nothing, where the configuration cannot work; ServiceLost; ReloadInterrupted.
  void Reload(DaemonConfig next);

  /// After `finished` came: whether the service goes on all the same, because what ended it is that a reloaded camera
  /// can never work, so that the configuration before it is in force again. Throws what else ended it.
  bool GoesOn();

  /// To be called now and then: a reloaded camera that was opened has proved its worth.
  void Settle();

  /// Ends capturing; does not wait.
  void Stop();
  /// Waits until only joining is left; false when the time is over.
  bool WaitForEnd(std::chrono::milliseconds timeout) const { return pipeline_->WaitForEnd(timeout); }
  /// As those of Pipeline.
  std::string UnderWay() const { return pipeline_->UnderWay(); }
  bool Abandon(std::chrono::milliseconds timeout) { return pipeline_->Abandon(timeout); }
  /// Waits for the end. Throws what ended it, if that was an error.
  void Join();

  /// As Pipeline::Stuck.
  std::string Stuck(const ProgressLimits& limits) const { return pipeline_->Stuck(limits); }
  const DaemonConfig& config() const { return config_; }

 private:
  struct Prepared;
  Prepared Prepare(const DaemonConfig& config, bool new_source, bool new_publisher);
  FrameBudget BudgetOf(const BudgetOptions& options, const PipelineOptions& pipeline);
  /// Ends the pipeline there is; what it leaves.
  PipelineState Conclude();
  void Start(DaemonConfig config, PipelineState state, Prepared prepared);

  std::string version_;
  ServiceParts parts_;
  PipelineEvents events_;
  Clock clock_;
  DaemonConfig config_;
  /// Of a thread while all workers are busy.
  struct Speed {
    int workers;
    double units_per_second;
  };
  std::optional<Speed> speed_;  ///< once it was measured
  std::optional<DaemonConfig> former_;  ///< until the camera of config_ has been opened
  std::atomic<bool> changing_{false};   ///< the pipeline that ends now is followed by another
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace chequer
