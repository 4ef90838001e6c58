#include "tools/status_board.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::seconds;

/// The daemon sends one a second; a third one missed is no accident.
constexpr seconds kStale{3};

std::string State(CameraState state) {
  switch (state) {
    case CameraState::kWaiting: return "waiting";
    case CameraState::kRunning: return "running";
    case CameraState::kEnded: return "ended";
  }
  return "?";
}

double Milliseconds(microseconds time) { return static_cast<double>(time.count()) / 1000; }

std::string Latency(const StatusMessage& status) {
  const auto total = std::find_if(status.stages.begin(), status.stages.end(),
                                  [](const StageLatency& stage) { return stage.stage == "total"; });
  if (total == status.stages.end() || total->frames == 0) return "-";
  return fmt::format("{:.1f} ({:.1f})", Milliseconds(total->median), Milliseconds(total->p99));
}

/// Names come from other programs: no control characters reach the terminal.
std::string Printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

using Row = std::vector<std::string>;

std::string Aligned(const std::vector<Row>& rows) {
  std::string text;
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      std::size_t width = 0;
      for (const Row& other : rows) width = std::max(width, other[i].size());
      const bool last = i + 1 == row.size();
      text += last ? row[i] : fmt::format("{:<{}}  ", row[i], width);
    }
    text += "\n";
  }
  return text;
}

}  // namespace

std::string Trouble(const StatusMessage& status, microseconds age) {
  if (age > kStale) return fmt::format("nothing has been heard for {:.0f} s", Milliseconds(age) / 1000);
  if (status.camera_state == CameraState::kEnded) return "the recording is over";
  if (status.camera_state == CameraState::kWaiting)
    return status.camera_message.empty() ? "waiting for the camera" : status.camera_message;
  if (!status.publisher.message.empty()) return status.publisher.message;
  if (!status.camera_message.empty()) return status.camera_message;
  if (status.publish_rate_hz <= 0) return "no frame is published";
  return {};
}

std::string QualityRemark(const StatusMessage& status) {
  const double markers =
      status.markers_mean * status.publish_rate_hz * static_cast<double>(status.window.count()) / 1e6;
  std::string remark;
  for (const NamedCount& count : status.detections) {
    if (count.count == 0 || !count.name.starts_with(kWarningCountPrefix)) continue;
    remark += fmt::format("{}{} {:.0f} %", remark.empty() ? "" : ", ", count.name.substr(kWarningCountPrefix.size()),
                          100 * static_cast<double>(count.count) / std::max(markers, static_cast<double>(count.count)));
  }
  return remark;
}

void StatusBoard::Add(const std::string& channel, const StatusMessage& status, MonotonicTime now) {
  if (name_.empty() || status.camera == name_) entries_[channel] = {status, now};
}

bool StatusBoard::AllWell(MonotonicTime now) const {
  return std::all_of(entries_.begin(), entries_.end(), [&](const auto& entry) {
    return Trouble(entry.second.status, now - entry.second.arrived).empty();
  });
}

std::string StatusBoard::Text(MonotonicTime now) const {
  std::vector<Row> rows{{"camera", "state", "frames/s", "markers", "latency ms (99 %)", "dropped", "version", "age s"}};
  std::string remarks;
  for (const auto& [channel, entry] : entries_) {
    const StatusMessage& status = entry.status;
    const microseconds age = now - entry.arrived;
    const std::string name = Printable(status.camera);
    rows.push_back({name, State(status.camera_state), fmt::format("{:.1f}", status.publish_rate_hz),
                    fmt::format("{:.1f}", status.markers_mean), Latency(status), std::to_string(status.frames_dropped),
                    Printable(status.version), fmt::format("{:.1f}", Milliseconds(age) / 1000)});
    if (const std::string trouble = Trouble(status, age); !trouble.empty())
      remarks += name + ": " + Printable(trouble) + "\n";
    if (const std::string quality = QualityRemark(status); !quality.empty())
      remarks += name + ": quality: " + Printable(quality) + " of the markers\n";
  }
  return Aligned(rows) + remarks;
}

}  // namespace chequer
