#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "chequer/detector.h"
#include "daemon/capture_report.h"
#include "daemon/latency_histogram.h"
#include "daemon/newest_queue.h"
#include "publish/messages.h"

namespace chequer {

/// When a frame passed the stages of the pipeline.
struct FrameTimes {
  MonotonicTime captured{};  ///< where latencies begin
  MonotonicTime started{};   ///< taken by a worker
  MonotonicTime detected{};
  MonotonicTime ordered{};  ///< its turn came
  MonotonicTime sent{};     ///< LCM has taken all its messages
};

/// What status_t tells that never changes.
struct StatusConstants {
  std::string version;
  std::string camera;
  int queue_capacity = 1;
  int workers = 1;
};

/// Adds up what status_t tells of the time since the last one, in fixed memory. One thread.
class Statistics {
 public:
  Statistics(StatusConstants constants, MonotonicTime start);

  /// Another pipeline goes on with it: what never changed before does now, the counts stay.
  void GoOnWith(StatusConstants constants) { constants_ = std::move(constants); }

  /// A frame is published: its messages are on their way.
  void Published(std::span<const MarkerPose> markers, const DetectStats& detect);
  /// The messages of a frame were sent.
  void Sent(const FrameTimes& times);

  /// The status since the last one; a new window begins. Publisher health and UTC are left to the caller.
  /// @param frames since the start, on their way to the workers
  StatusMessage Finish(const CaptureReport& capture, const QueueCounts& frames, MonotonicTime now);

  std::uint64_t published() const { return published_; }

 private:
  struct Stage {
    const char* name;
    LatencyHistogram times;
  };
  enum StageIndex : std::size_t { kQueue, kDetect, kOrder, kPublish, kTotal };

  StatusConstants constants_;
  MonotonicTime start_;
  MonotonicTime window_start_;
  std::uint64_t published_ = 0;
  std::uint64_t published_before_ = 0;  ///< the window
  std::uint64_t captured_before_ = 0;
  std::uint64_t markers_ = 0;  ///< in the window, as all below
  std::size_t markers_min_ = 0;
  std::size_t markers_max_ = 0;
  DetectStats detect_;
  std::array<std::uint64_t, kAllWarnings.size()> warnings_{};  ///< markers that carried each
  std::array<Stage, 5> stages_{{{"queue", {}}, {"detect", {}}, {"order", {}}, {"publish", {}}, {"total", {}}}};
};

}  // namespace chequer
