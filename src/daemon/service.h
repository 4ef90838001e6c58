#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
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
  /// Directs the log; called while no thread of the service runs.
  std::function<void(const DaemonConfig&)> set_up_logging;
  /// Called a few times a second while a pipeline is awaited that is to end for another: a camera that is being opened
  /// cannot be interrupted.
  std::function<void()> while_waiting;
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
  /// std::runtime_error, and changes nothing, where the configuration cannot work.
  void Reload(DaemonConfig next);

  /// After `finished` came: whether the service goes on all the same, because what ended it is that a reloaded camera
  /// can never work, so that the configuration before it is in force again. Throws what else ended it.
  bool GoesOn();

  /// To be called now and then: a reloaded camera that was opened has proved its worth.
  void Settle();

  /// Ends capturing; does not wait.
  void Stop();
  /// Waits for the end. Throws what ended it, if that was an error.
  void Join();

  /// As Pipeline::Stuck.
  std::string Stuck(const ProgressLimits& limits) const { return pipeline_->Stuck(limits); }
  const DaemonConfig& config() const { return config_; }

 private:
  struct Prepared;
  Prepared Prepare(const DaemonConfig& config, bool new_source, bool new_publisher) const;
  /// Ends the pipeline there is; what it leaves.
  PipelineState Conclude();
  void Start(DaemonConfig config, PipelineState state, Prepared prepared);

  std::string version_;
  ServiceParts parts_;
  PipelineEvents events_;
  Clock clock_;
  DaemonConfig config_;
  std::optional<DaemonConfig> former_;  ///< until the camera of config_ has been opened
  std::atomic<bool> changing_{false};   ///< the pipeline that ends now is followed by another
  std::unique_ptr<Pipeline> pipeline_;
};

}  // namespace chequer
