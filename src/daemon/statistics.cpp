#include "daemon/statistics.h"

#include <algorithm>
#include <utility>

namespace chequer {
namespace {

std::vector<NamedCount> Drops(const CaptureReport& capture, const QueueCounts& frames) {
  return {{"lost_before", capture.lost_before},
          {"corrupt", capture.corrupt},
          {"wrong_size", capture.wrong_size},
          {"superseded", frames.superseded},
          {"stopped", frames.discarded}};
}

std::vector<NamedCount> Detections(const DetectStats& stats) {
  const auto count = [](int value) { return static_cast<std::uint64_t>(value); };
  return {{"corner_candidates", count(stats.corner_candidates)},
          {"corners", count(stats.corners)},
          {"grids", count(stats.grids)},
          {"boards", count(stats.boards)},
          {"refused_border", count(stats.refused_border)},
          {"refused_fit", count(stats.refused_fit)},
          {"undecided", count(stats.undecided)},
          {"deferred", count(stats.deferred)},
          {"work", stats.work}};
}

/// How often each warning came, as "warning_" and its name.
void Append(std::span<const std::uint64_t> warnings, std::vector<NamedCount>& counts) {
  for (std::size_t i = 0; i < warnings.size(); ++i)
    counts.push_back({std::string(kWarningCountPrefix).append(WarningName(kAllWarnings[i])), warnings[i]});
}

void AddTo(DetectStats& sum, const DetectStats& stats) {
  sum.corner_candidates += stats.corner_candidates;
  sum.corners += stats.corners;
  sum.grids += stats.grids;
  sum.boards += stats.boards;
  sum.refused_border += stats.refused_border;
  sum.refused_fit += stats.refused_fit;
  sum.undecided += stats.undecided;
  sum.deferred += stats.deferred;
  sum.work += stats.work;
}

}  // namespace

Statistics::Statistics(StatusConstants constants, MonotonicTime start)
    : constants_(std::move(constants)), start_(start), window_start_(start) {}

void Statistics::Published(std::span<const MarkerPose> found, const DetectStats& detect) {
  const bool first_of_window = published_ == published_before_;
  const std::size_t markers = found.size();
  ++published_;
  for (const MarkerPose& marker : found)
    for (std::size_t i = 0; i < kAllWarnings.size(); ++i) warnings_[i] += marker.Has(kAllWarnings[i]) ? 1u : 0u;
  markers_ += markers;
  markers_min_ = first_of_window ? markers : std::min(markers_min_, markers);
  markers_max_ = first_of_window ? markers : std::max(markers_max_, markers);
  AddTo(detect_, detect);
}

void Statistics::Sent(const FrameTimes& times) {
  stages_[kQueue].times.Add(times.started - times.captured);
  stages_[kDetect].times.Add(times.detected - times.started);
  stages_[kOrder].times.Add(times.ordered - times.detected);
  stages_[kPublish].times.Add(times.sent - times.ordered);
  stages_[kTotal].times.Add(times.sent - times.captured);
}

StatusMessage Statistics::Finish(const CaptureReport& capture, const QueueCounts& frames, MonotonicTime now) {
  StatusMessage status;
  status.monotonic = now;
  status.uptime = now - start_;
  status.version = constants_.version;
  status.camera = constants_.camera;
  status.camera_state = capture.state;
  status.camera_source = capture.source;
  status.camera_message = capture.message;
  status.window = now - window_start_;
  const double seconds = std::chrono::duration<double>(status.window).count();
  const std::uint64_t published = published_ - published_before_;
  if (seconds > 0) {
    status.capture_rate_hz = static_cast<double>(frames.came - captured_before_) / seconds;
    status.publish_rate_hz = static_cast<double>(published) / seconds;
  }
  status.frames_captured = frames.came;
  status.frames_published = published_;
  status.drops = Drops(capture, frames);
  for (const NamedCount& drop : status.drops) status.frames_dropped += drop.count;
  status.queue_depth = frames.waiting;
  status.queue_capacity = constants_.queue_capacity;
  status.workers = constants_.workers;
  if (published > 0) {
    status.markers_mean = static_cast<double>(markers_) / static_cast<double>(published);
    status.markers_min = static_cast<int>(markers_min_);
    status.markers_max = static_cast<int>(markers_max_);
  }
  for (const Stage& stage : stages_)
    status.stages.push_back(
        {stage.name, stage.times.count(), stage.times.Quantile(0.5), stage.times.Quantile(0.99), stage.times.worst()});
  status.detections = Detections(detect_);
  Append(warnings_, status.detections);

  window_start_ = now;
  published_before_ = published_;
  captured_before_ = frames.came;
  markers_ = 0;
  detect_ = {};
  warnings_ = {};
  for (Stage& stage : stages_) stage.times.Clear();
  return status;
}

}  // namespace chequer
