#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "capture/frame_source.h"
#include "daemon/capture_report.h"
#include "daemon/newest_queue.h"
#include "daemon/sequence_counter.h"
#include "daemon/statistics.h"
#include "publish/publisher.h"

namespace chequer {

/// What outlives a pipeline and is handed to the one that takes its place when the configuration changes: what frames
/// come from and go to, and all that is counted since the daemon started.
struct PipelineState {
  std::unique_ptr<FrameSource> source{};
  std::unique_ptr<Publisher> publisher{};
  bool source_is_open = false;
  bool told_ready = false;
  SequenceCounter sequence{};
  CaptureReport capture{};
  QueueCounts former_queues{};          ///< the counts of those before
  PublisherHealth former_publishers{};  ///< the counts of those that were replaced
  std::optional<Statistics> statistics{};

  /// Another source, not yet open, takes the place of the one there is, which is gone at once: a camera can be opened
  /// only once.
  void ReplaceSource(std::unique_ptr<FrameSource> with);
  /// Another publisher takes the place of the one there is.
  void ReplacePublisher(std::unique_ptr<Publisher> with);
};

}  // namespace chequer
