#include "daemon/report.h"

#include <spdlog/fmt/fmt.h>

#include "daemon/notify.h"

namespace chequer {
namespace {

constexpr std::chrono::hours kPeriod{1};

}  // namespace

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

std::vector<LogField> ReportFields(const StatusMessage& status) {
  std::vector<LogField> fields{{"CHEQUER_FRAMES_CAPTURED", std::to_string(status.frames_captured)},
                               {"CHEQUER_FRAMES_PUBLISHED", std::to_string(status.frames_published)},
                               {"CHEQUER_FRAMES_DROPPED", std::to_string(status.frames_dropped)},
                               {"CHEQUER_MESSAGES_FAILED", std::to_string(status.publisher.failed)},
                               {"CHEQUER_FRAMES_PER_SECOND", fmt::format("{:.2f}", status.publish_rate_hz)},
                               {"CHEQUER_MARKERS_PER_FRAME", fmt::format("{:.2f}", status.markers_mean)}};
  for (const StageLatency& stage : status.stages) {
    if (stage.stage != "total" || stage.frames == 0) continue;
    fields.push_back({"CHEQUER_LATENCY_MEDIAN_US", std::to_string(stage.median.count())});
    fields.push_back({"CHEQUER_LATENCY_P99_US", std::to_string(stage.p99.count())});
    fields.push_back({"CHEQUER_LATENCY_WORST_US", std::to_string(stage.worst.count())});
  }
  return fields;
}

void Report::Take(const StatusMessage& status) {
  if (status.camera_state != CameraState::kRunning || status.frames_published == 0) return;
  const MonotonicTime now = clock_.monotonic();
  if (now < next_) return;
  next_ = now + kPeriod;
  LogEvent(LogLevel::kInfo, "report", StatusLine(status), ReportFields(status));
}

}  // namespace chequer
